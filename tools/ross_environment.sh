#!/bin/sh
# Install ROSS, the program the beam rotors are compared with, in .venv-ross. Quick when done.
set -eu
cd "$(dirname "$0")/.."

PYTHON=/usr/bin/python3
# The newest ROSS that this Python can have: 3.1 needs 3.13 (Debian 13). Times and last digits hang
# on numpy, scipy and numba; ROSS 2.3.0 does not load with plotly 7.
if $PYTHON -c 'import sys; sys.exit(sys.version_info < (3, 13))'; then
    PACKAGES="ross-rotordynamics==3.1.0 numpy==2.5.5 scipy==1.18.1 numba==0.68.1 plotly==7.1.0"
else
    PACKAGES="ross-rotordynamics==2.3.0 numpy==2.4.6 scipy==1.17.1 numba==0.68.1 plotly==6.9.0"
fi
STAMP=.venv-ross/.installed

[ "$(cat $STAMP 2>/dev/null)" != "$PACKAGES" ] || exit 0
echo "setup: environment .venv-ross"
[ -x .venv-ross/bin/python ] || $PYTHON -m venv .venv-ross
# git and the linter pass it by
echo '*' > .venv-ross/.gitignore
# shellcheck disable=SC2086
.venv-ross/bin/python -m pip install -q --disable-pip-version-check $PACKAGES
# The first import compiles; do it here rather than in a test with a time limit.
.venv-ross/bin/python -W ignore -c "import ross" >/dev/null 2>&1
printf '%s' "$PACKAGES" > $STAMP
