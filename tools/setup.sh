#!/bin/sh
# Install what solidwhirl needs on Debian: system packages, then .venv. Quick when nothing is missing.
set -eu
cd "$(dirname "$0")/.."

# Compiled parts come from Debian; the GL and X libraries are what the wheels of gmsh and VTK link to.
# libopenblas0-pthread replaces the reference BLAS, which makes factorisations 4 to 8 times slower.
PACKAGES="python3-venv python3-dolfinx python3-petsc4py python3-slepc4py gcc g++ libopenblas0-pthread
libgl1 libglu1-mesa libxrender1 libxcursor1 libxft2 libxinerama1 libegl1"
case ${1:-} in
    # the long comparisons run another program beside ours
    verify) PACKAGES="$PACKAGES calculix-ccx" ;;
    # the tests look at pages
    browser) PACKAGES="$PACKAGES chromium chromium-driver" ;;
esac
PYTHON=/usr/bin/python3
STAMP=.venv/.installed
# what package managers and compilers say
LOG=build/setup.log
WANTED=$(cat pyproject.toml tools/setup.sh tools/constraints.py tools/warm_cache.py | sha256sum)

missing() {
    for package in $PACKAGES; do
        dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null | grep -qx installed || printf '%s ' "$package"
    done
}

# step TEXT DURATION COMMAND...: say what is done and how long it takes; its output goes to the log
step() {
    echo "setup: $1, about $2"
    began=$(date +%s)
    shift 2
    mkdir -p "$(dirname $LOG)"
    "$@" >> $LOG 2>&1 || {
        tail -n 15 $LOG >&2
        echo "setup: this step failed; all that it said is in $LOG" >&2
        exit 1
    }
    echo "setup: done in $(($(date +%s) - began)) s"
}

apt_install() {
    # another apt may hold the lock for a while
    $run apt-get -q -o DPkg::Lock::Timeout=300 update &&
        $run env DEBIAN_FRONTEND=noninteractive apt-get -q -y -o DPkg::Lock::Timeout=300 \
            install --no-install-recommends "$@"
}

environment() {
    { [ -x .venv/bin/python ] || $PYTHON -m venv --system-site-packages .venv; } &&
        $PYTHON tools/constraints.py > .venv/constraints.txt &&
        .venv/bin/python -m pip install --disable-pip-version-check \
            -c .venv/constraints.txt -e '.[pipeline,dev,docs]'
}

install_packages() {
    if [ "$(id -u)" = 0 ]; then run=""; elif command -v sudo >/dev/null; then run=sudo; else
        echo "setup: these Debian packages are missing and only root can install them: $1" >&2
        echo "setup: run as root: apt-get install --no-install-recommends $1" >&2
        exit 1
    fi
    # shellcheck disable=SC2086
    step "installing $1" "a minute, most of it the download" apt_install $1
}

command -v dpkg-query >/dev/null || {
    echo "setup: this is no Debian system (dpkg-query is missing); dolfinx comes from Debian's packages" >&2
    exit 1
}
absent=$(missing)
[ -z "$absent" ] || install_packages "$absent"

if [ "$(cat $STAMP 2>/dev/null)" != "$WANTED" ]; then
    step "Python environment .venv" "a minute" environment
    step "compiling the finite element kernels once" "half a minute" .venv/bin/python tools/warm_cache.py
    printf '%s' "$WANTED" > $STAMP
fi
