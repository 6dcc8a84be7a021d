#!/usr/bin/env bash
# Ten minutes of 32 voices on 16 tactors of a virtual card, in blocks of 128, while every core has other work: no callback may take longer
# than its period by its own CPU time, and 99.9 % of them less than a quarter of it.
#
#   benches/ten-minutes.sh [SECONDS]
set -euo pipefail
cd "$(dirname "$0")/.."
readonly seconds=${1:-600}

cargo build --release --quiet
scratch=$(mktemp -d)
workers=()
trap 'kill "${workers[@]}" 2> /dev/null || true; rm -rf "$scratch"' EXIT
# One that computes and one that moves memory, by turns.
for ((n = 0; n < $(nproc); n++)); do
  if ((n % 2 == 0)); then
    sha256sum /dev/zero &
  else
    dd if=/dev/zero of=/dev/null bs=64M 2> /dev/null &
  fi
  workers+=("$!")
done

"${CARGO_TARGET_DIR:-target}/release/pacinian" play benches/steady.toml --rig rigs/demo-16.toml --device virtual --block 128 \
  --duration "$seconds" > "$scratch/said"
grep ' over their time, ' "$scratch/said" || { echo 'nothing was told of callbacks over their time' >&2; exit 1; }
for worker in "${workers[@]}"; do
  kill -0 "$worker" || { echo 'the other work ended before' >&2; exit 1; }
done
awk '/ over their time, / {
  if (!match($0, /99\.9 % below [0-9.]+ %/)) { print "no load was told"; exit 1 }
  share = substr($0, RSTART + 13, RLENGTH - 15)
  match($0, /[0-9]+ over their time/)
  over = substr($0, RSTART) + 0
  printf "over their time: %d (at most 0); 99.9 %% below %s %% of it (at most 25)\n", over, share
  exit !(over == 0 && share + 0 < 25)
}' "$scratch/said"
