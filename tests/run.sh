#!/bin/bash
# Installs what the tests need, and passes them: format, lints, documentation, and all tests on every driver there is.
set -euo pipefail
cd "$(dirname "$0")/.."

tests/setup.sh tests

tools="spirv-val glslangValidator"
swiftshader=/usr/lib/chromium/vk_swiftshader_icd.json
if [ -e "$swiftshader" ]; then
    tools="$tools chromium"
else
    echo "chromium is not here: the tests 'tint' and the laws on SwiftShader are skipped"
fi
export VRCS_REQUIRE_TOOLS="$tools"
# Mesa's layer for choosing among displays complains where there is no display
export NODEVICE_SELECT=1

# the software driver that the figures and the golden pictures are made with
lavapipe="$(find /usr/share/vulkan/icd.d -name 'lvp_icd*.json' | sort | tr '\n' ':')"

echo "== format, lints, documentation"
cargo fmt --all -- --check
cargo clippy --workspace --all-targets -- -D warnings
RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps

echo "== licences and crates that nobody maintains, by cargo-deny"
# the crates of other platforms too, which no build here has fetched
cargo fetch --quiet --locked
cargo deny --offline check licenses bans sources
# the list of advisories lies on the network
if cargo deny fetch db 2>/dev/null; then
    cargo deny --offline check advisories
else
    echo "THE ADVISORIES WERE NOT CHECKED: their list cannot be fetched"
fi

msrv="$(sed -n 's/^rust-version = "\(.*\)"/\1/p' Cargo.toml)"
case "$(rustc --version)" in
"rustc $msrv."*) echo "== Rust $msrv, the oldest that will do, is the one that runs" ;;
*)
    echo "== Rust $msrv, the oldest that will do"
    cargo "+$msrv" check --workspace
    ;;
esac

echo "== tests, on lavapipe"
# the examples are built with the tests: they need not be compiled once more for the test that runs them
VRCS_EXAMPLES_BUILT=1 VK_DRIVER_FILES="${lavapipe%:}" cargo test --workspace --no-fail-fast

if [ -e "$swiftshader" ]; then
    echo "== laws, on SwiftShader"
    # the whole workspace, so that what was built for lavapipe will do
    VK_DRIVER_FILES="$swiftshader" cargo test --workspace --test laws --test builder --test rates --test attachment --test retired
    VRCS_CASES=10 VK_DRIVER_FILES="$swiftshader" cargo test --workspace --test barriers --test analyse
    # the loops of pictures ask no driver
    VK_DRIVER_FILES="$swiftshader" cargo test --workspace --test hard_cases -- --skip closed_loop
fi
