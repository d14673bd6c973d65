#!/bin/bash
# Run a command with this commit on another release of Debian: tools/in_debian.sh trixie make test
# A root made by debootstrap is kept in /var/cache/solidwhirl (SOLIDWHIRL_ROOTS); needs root itself.
set -euo pipefail
cd "$(dirname "$(realpath "$0")")/.."
[ $# -ge 2 ] || { echo "usage: tools/in_debian.sh SUITE COMMAND..." >&2; exit 2; }
[ "$(id -u)" = 0 ] || { echo "in_debian: only root can make and enter the root of a system" >&2; exit 2; }
suite=$1; shift
recipe=$(cat tools/in_debian.sh tools/setup.sh tools/constraints.py pyproject.toml | sha256sum | cut -c1-12)
root=${SOLIDWHIRL_ROOTS:-/var/cache/solidwhirl}/$suite-$recipe

make_root() {
    command -v debootstrap >/dev/null || { apt-get -qq update; apt-get -qq install -y debootstrap; }
    mirror=$(apt-get indextargets --format '$(SITE)' 'Created-By: Packages' |
        grep -v security | grep '/debian/\?$' | sort -u | head -1)
    rm -rf --one-file-system "$root"
    mkdir -p "$(dirname "$root")"
    debootstrap --variant=minbase --include=ca-certificates,make,git "$suite" "$root" "${mirror:-http://deb.debian.org/debian}"
    # nothing that a test reads, and no waiting for the disk
    echo force-unsafe-io > "$root/etc/dpkg/dpkg.cfg.d/solidwhirl"
    printf 'path-exclude=/usr/share/%s/*\n' doc man locale info >> "$root/etc/dpkg/dpkg.cfg.d/solidwhirl"
    # trust what this machine trusts, and find what it finds
    cp /etc/ssl/certs/ca-certificates.crt "$root/etc/ssl/certs/ca-certificates.crt"
    cp /etc/hosts "$root/etc/hosts"
    cp -L /etc/resolv.conf "$root/etc/resolv.conf" 2>/dev/null || true
}

# mounts are private: they are gone when the command is
enter() {
    unshare --mount --propagation private bash -euc '
        root=$1; shift
        mount -t proc proc "$root/proc"
        mount --rbind /sys "$root/sys"
        mount -t tmpfs -o size=4g shm "$root/dev/shm"
        exec env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C.UTF-8 \
            UCX_LOG_LEVEL=fatal HWLOC_HIDE_ERRORS=2 OPENBLAS_NUM_THREADS=1 \
            PIP_CERT=/etc/ssl/certs/ca-certificates.crt SSL_CERT_FILE=/etc/ssl/certs/ca-certificates.crt \
            OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1 \
            chroot "$root" bash -c "cd /src && exec \"\$@\"" - "$@"' - "$root" "$@"
}

if [ ! -e "$root/.ready" ]; then
    echo "in_debian: making $root"
    make_root > "/tmp/in_debian_$suite.log" 2>&1 || { tail -20 "/tmp/in_debian_$suite.log" >&2; exit 1; }
fi
# the files of the last commit; the environment of an earlier call stays
mkdir -p "$root/src"
find "$root/src" -mindepth 1 -maxdepth 1 ! -name .venv -exec rm -rf {} +
git archive HEAD | tar -x -C "$root/src"
if [ ! -e "$root/.ready" ]; then
    enter tools/setup.sh
    touch "$root/.ready"
fi
enter "$@"
