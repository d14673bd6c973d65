#!/bin/bash
# Run a command with this project on another release of Debian: tools/in_debian.sh trixie make check
# Takes the last commit, or with SOLIDWHIRL_FILES=working the files as they lie here (but not what git
# ignores). A root made by debootstrap is kept in /var/cache/solidwhirl (SOLIDWHIRL_ROOTS), and made
# again where it is gone or damaged. Ends with 75 where none can be made: not as root, no debootstrap,
# no network.
set -euo pipefail
cd "$(dirname "$(realpath "$0")")/.."
[ $# -ge 2 ] || { echo "usage: tools/in_debian.sh SUITE COMMAND..." >&2; exit 2; }
suite=$1; shift
files=${SOLIDWHIRL_FILES:-commit}
case $files in commit | working) ;; *)
    echo "in_debian: SOLIDWHIRL_FILES is '$files'; commit and working are allowed" >&2; exit 2 ;;
esac

cannot() { echo "in_debian: $1" >&2; exit 75; }

mirror() {
    # a list through a pipe: head would end the first command early
    local sites
    sites=$(apt-get indextargets --format '$(SITE)' 'Created-By: Packages' | grep -v security |
        grep '/debian/\?$' | sort -u) || true
    sites=${sites%%$'\n'*}
    echo "${sites:-http://deb.debian.org/debian}"
}

# what this machine reaches, through apt's own settings, and the packages of Python
reachable() {
    local folder found=0
    folder=$(mktemp -d)
    /usr/lib/apt/apt-helper -o Acquire::Retries=1 -o Acquire::http::Timeout=20 \
        download-file "$(mirror)/dists/$suite/Release" "$folder/Release" >/dev/null 2>&1 || found=$?
    rm -rf "$folder"
    [ "$found" != 0 ] || /usr/bin/python3 -c '
import sys, urllib.request
urllib.request.urlopen(sys.argv[1] + "/pip/", timeout=20)' \
        "${PIP_INDEX_URL:-https://pypi.org/simple}" >/dev/null 2>&1 || found=$?
    return "$found"
}

# called where a failing command does not end the script
make_root() {
    rm -rf --one-file-system "$root"
    debootstrap --variant=minbase --include=ca-certificates,make,git "$suite" "$root" "$(mirror)" || return 1
    # a mirror's copy of sid may be some days old
    echo 'Acquire::Check-Valid-Until "false";' > "$root/etc/apt/apt.conf.d/solidwhirl"
    # nothing that a test reads, and no waiting for the disk
    echo force-unsafe-io > "$root/etc/dpkg/dpkg.cfg.d/solidwhirl"
    printf 'path-exclude=/usr/share/%s/*\n' doc man locale info >> "$root/etc/dpkg/dpkg.cfg.d/solidwhirl"
    # trust what this machine trusts, and find what it finds
    cp /etc/ssl/certs/ca-certificates.crt "$root/etc/ssl/certs/ca-certificates.crt"
    cp /etc/hosts "$root/etc/hosts"
    cp -L /etc/resolv.conf "$root/etc/resolv.conf" 2>/dev/null || true
}

# from nothing to a system without what setup.sh installs
new_root() {
    reachable || cannot "$(mirror) or the packages of Python are not to be reached, and $1"
    command -v debootstrap >/dev/null ||
        { apt-get -qq update && apt-get -qq install -y debootstrap; } > "$log" 2>&1 ||
        cannot "debootstrap can't be installed, see $log"
    echo "in_debian: making $root" >&2
    make_root > "$log" 2>&1 || { tail -20 "$log" >&2; exit 1; }
    touch "$root/.debian"
}

# mounts are private: they are gone when the command is
enter() {
    local name network=()
    for name in http_proxy https_proxy no_proxy PIP_INDEX_URL; do
        [ -z "${!name:-}" ] || network+=("$name=${!name}")
    done
    unshare --mount --propagation private bash -euc '
        root=$1; shift
        # a mount itself, so that programs in it can have mounts of their own
        mount --bind "$root" "$root"
        mount -t proc proc "$root/proc"
        mount --rbind /sys "$root/sys"
        mount -t tmpfs -o size=4g shm "$root/dev/shm"
        exec env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C.UTF-8 \
            UCX_LOG_LEVEL=fatal HWLOC_HIDE_ERRORS=2 OPENBLAS_NUM_THREADS=1 \
            PIP_CERT=/etc/ssl/certs/ca-certificates.crt SSL_CERT_FILE=/etc/ssl/certs/ca-certificates.crt \
            OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1 \
            OMPI_MCA_mpi_yield_when_idle=1 \
            chroot "$root" bash -c "cd /src && exec env \"\$@\"" - "$@"' - "$root" "${network[@]}" "$@"
}

# environments of an earlier call stay
put_files() {
    mkdir -p "$root/src"
    find "$root/src" -mindepth 1 -maxdepth 1 ! -name '.venv*' -exec rm -rf {} +
    if [ "$files" = commit ]; then
        git archive HEAD | tar -x -C "$root/src"
    else
        # what is deleted but still known to git is left out
        git ls-files -z --cached --others --exclude-standard |
            while IFS= read -r -d '' path; do
                if [ -e "$path" ] || [ -L "$path" ]; then printf '%s\0' "$path"; fi
            done | sort -zu | tar -c --null --files-from=- --ignore-failed-read | tar -x -C "$root/src"
    fi
}

# ROSS reads what the tests export
up_to_date() { enter tools/setup.sh >&2 9>&- && enter tools/ross_environment.sh >&2 9>&-; }

[ "$(id -u)" = 0 ] || cannot "only root can make and enter the root of a system"
unshare --mount --propagation private mount -t tmpfs test /mnt 2>/dev/null ||
    cannot "mounts of its own are not allowed here (CAP_SYS_ADMIN)"
# packages that are missing are installed at every call, so what is not made again hangs on this alone
recipe=$(declare -f make_root | sha256sum | cut -c1-12)
root=${SOLIDWHIRL_ROOTS:-/var/cache/solidwhirl}/$suite-$recipe
log=/tmp/in_debian_$suite.log
mkdir -p "$(dirname "$root")" 2>/dev/null && [ -w "$(dirname "$root")" ] ||
    cannot "$(dirname "$root") can't be written to; SOLIDWHIRL_ROOTS names another folder"
# one call at a time: they share the files
exec 9> "$root.lock"
flock --nonblock 9 || { echo "in_debian: waiting for another call" >&2; flock 9; }

made=""
[ -e "$root/.debian" ] || { new_root "there is no root yet"; made=now; }
# of what is still changing, packages of last month say little
if [ "$suite" = sid ] && [ -n "$(find "$root/.debian" -mtime +30)" ] && reachable; then
    new_root "the root is old"; made=now
fi
put_files
if ! up_to_date; then
    [ -z "$made" ] || { reachable && exit 1; cannot "the network was lost on the way"; }
    # broken off in the midst of an installation, or no longer what its repository has
    new_root "the root lacks something"
    put_files
    up_to_date || exit 1
fi
# what outlives the command doesn't keep the lock
enter "$@" 9>&-
