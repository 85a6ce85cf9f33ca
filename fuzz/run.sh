#!/bin/sh
# sh fuzz/run.sh TARGET SECONDS [libFuzzer's own options]: new input goes to corpus-new/TARGET, findings to artifacts/.
set -eu
cd "$(dirname "$0")"
target=$1 seconds=$2
shift 2
# What cargo-fuzz sets, without the sanitizers, which need a nightly compiler.
export RUSTFLAGS="-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
-Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table \
-Cllvm-args=-sanitizer-coverage-trace-compares -Clink-dead-code -Cforce-frame-pointers"
# With a target named, the flags are not for build scripts.
host=$(rustc -vV | sed -n 's/^host: //p')
cargo build --release --target "$host" --bin "$target"
mkdir -p "corpus-new/$target" artifacts
"${CARGO_TARGET_DIR:-target}/$host/release/$target" "corpus-new/$target" "corpus/$target" \
    -max_total_time="$seconds" -max_len=8192 -timeout=5 -rss_limit_mb=512 -artifact_prefix=artifacts/ "$@"
