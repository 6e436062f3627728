#!/usr/bin/env bash
# The main job, on a recording that is simulated because a real one cannot be shipped: what `make demo` runs.
#   bash examples/demo.sh [folder for the results]
set -euo pipefail
out=${1:-out/demo}
here=$(dirname "${BASH_SOURCE[0]}")/demo
mkdir -p "$out"

step() { # say the command, then run it
  printf '\n$'
  for word in "$@"; do if [[ $word == *" "* ]]; then printf ' "%s"' "$word"; else printf ' %s' "$word"; fi; done
  printf '\n'
  "$@"
}

# An indenter presses 61 times along the row, every half millimetre. Sensors drift and carry noise, the silicone relaxes,
# gains differ, sensor p3 is dead, and y = 0 lies at 17.3 mm on the motor's axis, which the finger as drawn does not know.
step subskin simulate "$here/real.toml" -o "$out/recording.csv" --recording --count 61 --grid \
  --position "2.3 mm .. 32.3 mm" --origin "17.3 mm" --force "40 N/m" \
  --drift 60 --relaxation 0.2 --spread 0.2 --dead 3 --seed 1

step subskin segment "$here/finger.toml" "$out/recording.csv" -o "$out/presses.csv"
step subskin calibrate "$here/finger.toml" "$out/presses.csv" -o "$out/calibrated.toml" --every 2
step subskin locate "$out/calibrated.toml" "$out/presses.csv" -o "$out/located.csv" --every 2 --skip-used \
  --truth position --figure "$out/truth.png"

# The same on an area: sixteen barometers under touches on points.
step python "$here/area.py" "$out"
