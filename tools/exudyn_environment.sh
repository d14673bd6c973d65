#!/bin/sh
# Install Exudyn, which reduced solids are compared with, in .venv-exudyn. Quick when done.
set -eu
cd "$(dirname "$0")/.."

# Exudyn's reduction runs in scipy, so its times hang on these versions.
PACKAGES="exudyn==1.13.6 numpy==2.4.6 scipy==1.17.1"
PYTHON=/usr/bin/python3
STAMP=.venv-exudyn/.installed

[ "$(cat $STAMP 2>/dev/null)" != "$PACKAGES" ] || exit 0
echo "setup: environment .venv-exudyn"
[ -x .venv-exudyn/bin/python ] || $PYTHON -m venv .venv-exudyn
# git and the linter pass it by
echo '*' > .venv-exudyn/.gitignore
# shellcheck disable=SC2086
.venv-exudyn/bin/python -m pip install -q --disable-pip-version-check $PACKAGES
# The first import compiles; it is not to be measured.
.venv-exudyn/bin/python -W ignore -c "import exudyn.FEM" >/dev/null 2>&1
printf '%s' "$PACKAGES" > $STAMP
