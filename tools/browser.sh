#!/bin/sh
# Install the browser in which the tests look at pages: Debian's chromium with its driver. Quick when
# both are there.
set -eu
PACKAGES="chromium chromium-driver"

missing=""
for package in $PACKAGES; do
    dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null | grep -qx installed || missing="$missing $package"
done
[ -n "$missing" ] || exit 0
if [ "$(id -u)" = 0 ]; then run=""; elif command -v sudo >/dev/null; then run=sudo; else
    echo "browser: these Debian packages are missing and only root can install them:$missing" >&2
    echo "browser: run as root: apt-get install --no-install-recommends$missing" >&2
    exit 1
fi
echo "browser: installing$missing"
$run apt-get -qq -o DPkg::Lock::Timeout=300 update
# shellcheck disable=SC2086
$run env DEBIAN_FRONTEND=noninteractive apt-get -qq -y -o DPkg::Lock::Timeout=300 \
    install --no-install-recommends $missing >/dev/null
