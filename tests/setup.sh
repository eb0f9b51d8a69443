#!/bin/sh
# Installs what is missing: `setup.sh driver` a software Vulkan driver, `setup.sh tests` what the tests need besides.
# g++ compiles the picture metric FLIP.
# Packages that are there are left alone. On Ubuntu, whose apt has no real Chromium, Chromium is passed over.
set -eu

wanted="mesa-vulkan-drivers libvulkan1 g++"
if [ "${1:-tests}" = tests ]; then
    wanted="$wanted spirv-tools glslang-tools"
    if ! grep -qi '^ID=ubuntu' /etc/os-release; then
        wanted="$wanted chromium"
    fi
fi

missing=""
for package in $wanted; do
    if ! dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q 'install ok installed'; then
        missing="$missing $package"
    fi
done

install_packages() {
    as_root=""
    if [ "$(id -u)" != 0 ]; then
        as_root="sudo"
    fi
    echo "installing$missing" >&2
    export DEBIAN_FRONTEND=noninteractive
    $as_root apt-get update -q
    # shellcheck disable=SC2086 # a list of words
    $as_root apt-get install -q -y --no-install-recommends $missing
}

if [ -n "$missing" ]; then
    install_packages
fi

# the licences of what we depend on are checked by a program; the oldest Rust that will do has to be there, if there is another
if [ "${1:-tests}" = tests ]; then
    if ! cargo deny --version >/dev/null 2>&1; then
        echo "installing cargo-deny" >&2
        cargo install --quiet --debug --locked cargo-deny@0.20.2
    fi
    msrv="$(sed -n 's/^rust-version = "\(.*\)"/\1/p' "$(dirname "$0")/../Cargo.toml")"
    case "$(rustc --version)" in
    "rustc $msrv."*) ;;
    *) cargo "+$msrv" --version >/dev/null 2>&1 || rustup toolchain install --profile minimal "$msrv" ;;
    esac
fi
