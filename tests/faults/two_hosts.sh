#!/bin/bash
# Two hosts of two ranks each on this machine, as network namespaces with names of their own.
# two_hosts.sh COMMAND ...: run a command under mpirun on both; root only.
# two_hosts.sh agent NAMES HOST COMMAND ...: what mpirun starts its part on a host with.
set -eu
in_host() { # NAMESPACE COMMAND: the name of the host is that of the namespace
    exec ip netns exec "$1" unshare --uts sh -c "hostname $1; $2"
}
if [ "$1" = agent ]; then
    names=$2 last=${3##*.}
    shift 3
    in_host "$names$last" "$*"
fi

names=sw$$h
remove() {
    for host in 1 2; do ip netns del "$names$host" 2>/dev/null || true; done
}
trap remove EXIT
for host in 1 2; do ip netns add "$names$host"; done
ip link add "sw$$v1" netns "${names}1" type veth peer name "sw$$v2" netns "${names}2"
for host in 1 2; do
    ip -n "$names$host" addr add "10.77.0.$host/24" dev "sw$$v$host"
    ip -n "$names$host" link set lo up
    ip -n "$names$host" link set "sw$$v$host" up
done
words=$(printf '%q ' "$@")
launch="mpirun --host 10.77.0.1:2,10.77.0.2:2 --mca plm_rsh_agent '$0 agent $names'"
(in_host "${names}1" "$launch --mca btl tcp,vader,self $words")
