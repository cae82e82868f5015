#!/bin/sh
# Install vcmm into .venv: tools/venv.sh STAMP EXTRAS PYTHON
#
# STAMP is written last, so an interrupted installation is done again. EXTRAS is "" or for example "[dev]".
# Packages come from wherever pip is set up to find them; constraints.txt only says which versions were tested.
set -eu
stamp=$1 extras=$2 wanted=$3

usable() { "$1" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; }

find_python() {
    for candidate in "$wanted" python3 python3.13 python3.12 python3.11; do
        if usable "$candidate"; then
            echo "$candidate"
            return
        fi
    done
    found=$("$wanted" --version 2>&1 || true)
    echo "vcmm needs Python 3.11 or newer; $wanted is: ${found:-not installed}." >&2
    echo "Install one (Debian, Ubuntu: apt-get install python3 python3-venv) or name it: make PYTHON=/path/to/python3" >&2
    exit 1
}

make_venv() {
    python=$(find_python)
    if ! "$python" -c 'import venv, ensurepip' 2>/dev/null; then
        echo "$python cannot make virtual environments: its venv module is missing." >&2
        echo "Debian, Ubuntu: apt-get install python3-venv (or the package of that version, such as python3.12-venv)" >&2
        exit 1
    fi
    echo "making .venv with $("$python" --version)"
    rm -rf .venv
    "$python" -m venv .venv
}

if ! usable .venv/bin/python; then
    make_venv
fi
echo "installing vcmm$extras into .venv (a minute or two, once)"
if ! .venv/bin/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e ".$extras"; then
    echo "The installation failed; the lines above say why. Without network, point pip at a folder of wheels (PIP_FIND_LINKS)." >&2
    exit 1
fi
touch "$stamp"
