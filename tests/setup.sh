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
if [ -z "$missing" ]; then
    exit 0
fi

as_root=""
if [ "$(id -u)" != 0 ]; then
    as_root="sudo"
fi
echo "installing$missing" >&2
export DEBIAN_FRONTEND=noninteractive
$as_root apt-get update -q
# shellcheck disable=SC2086 # a list of words
$as_root apt-get install -q -y --no-install-recommends $missing
