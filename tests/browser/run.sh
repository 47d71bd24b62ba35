#!/usr/bin/env bash
# Checks pages of `carom report` in a headless Chromium:
# tests/browser/run.sh PROGRAM [FOLDER FOR SCREENSHOTS]
# PROGRAM is carom. Needs Python 3 and Chromium (CHROMIUM names another one); without them no page is tested.
# Node tests the picture between frames, and bad scenes, which Python writes.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
program=$(realpath "${1:?usage: tests/browser/run.sh PROGRAM [FOLDER]}")
runs=$(mktemp -d)
trap 'rm -rf "$runs"' EXIT
pictures=${2:-$runs}

if command -v node >/dev/null; then
    echo between
    node "$here/between.js"
    node "$here/editor_test.mjs"
    if [ -f "$here/../../web/carom.module" ] && command -v python3 >/dev/null; then
        node "$here/bad_scenes.mjs" 600 --patience 20 --program "$program" --compare 191
    fi
else
    echo "skipped: the editor and bad scenes, no node"
fi
if ! command -v python3 >/dev/null; then
    echo "skipped: no python3"
    exit 0
fi
if ! python3 -B "$here/check.py" --find >/dev/null; then
    echo "skipped: no Chromium"
    exit 0
fi
mkdir -p "$pictures"
"$program" run "$here/../../configs/square_well_fluid.toml" --quiet --out "$runs/fluid" --until-events 20000 \
    --set run.equilibration_events=2000 --set fill.0.count=500 >/dev/null
"$program" run "$here/../../configs/hopper.toml" --quiet --out "$runs/hopper" --until-time 12 >/dev/null
"$program" run "$here/../../configs/funnel.toml" --quiet --out "$runs/funnel" --until-time 6 >/dev/null
"$program" run "$here/../../configs/piston.toml" --quiet --out "$runs/piston" --set fill.0.count=60 --set output.frame_interval=44 >/dev/null
"$program" run "$here/../../configs/rough_cooling.toml" --quiet --out "$runs/rough" --until-time 6 --set fill.0.count=108 \
    --set output.frame_interval=0.5 >/dev/null
"$program" sweep "$here/../../configs/equation_of_state.toml" --quiet --out "$runs/sweep" --vary fill.0.packing_fraction=0.1,0.3 --vary seed=1,2 \
    --set fill.0.count=256 --set run.equilibration_events=5000 --set run.until_events=30000 >/dev/null
cp "$here/measurements.json" "$runs/fluid/"
for run in fluid hopper funnel piston rough; do
    "$program" report "$runs/$run" >/dev/null
done
timeout 300 python3 -B "$here/check.py" "$runs" "$pictures"
if [ -f "$here/../../web/carom.module" ]; then
    "$program" live "$here/../../configs/maxwell.toml" --out "$runs/maxwell.html" >/dev/null
    timeout 300 python3 -B "$here/live.py" "$runs/maxwell.html" --pictures "$pictures" --longest-gap 60000
else
    echo "skipped: pages on which scenes run, no module (web/build)"
fi
