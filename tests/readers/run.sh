#!/usr/bin/env bash
# Opens files of the program with the programs that they are written for:
# tests/readers/run.sh target/release/carom
# Needs Python 3.11 or later and a package index. Reuses the environment in CAROM_READERS_VENV, or creates it
# there. Without this variable, the environment is in a temporary folder.
set -euo pipefail
program=$(realpath "${1:?usage: run.sh PROGRAM}")
cd "$(dirname "$0")"

environment=${CAROM_READERS_VENV:-}
if [[ -z $environment ]]; then
    environment=$(mktemp -d)
    trap 'rm -rf "$environment"' EXIT
fi
if [[ ! -x $environment/bin/python ]]; then
    python3 -m venv "$environment"
fi
# Takes a moment if everything is installed already.
"$environment/bin/pip" install --quiet --disable-pip-version-check -r requirements.txt
PYTHONDONTWRITEBYTECODE=1 QT_QPA_PLATFORM=offscreen "$environment/bin/python" check.py "$program"
