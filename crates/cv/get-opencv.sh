#!/usr/bin/env bash
# Installs what crates/cv is built with: OpenCV's development files, a C++ compiler, clang. What is there is kept.
set -euo pipefail

fail() { echo "get-opencv.sh: $*" >&2; exit 1; }

missing=()
command -v g++ >/dev/null 2>&1 || missing+=(g++)
command -v pkg-config >/dev/null 2>&1 || missing+=(pkg-config)
command -v clang >/dev/null 2>&1 || missing+=(clang)
pkg-config --exists opencv4 2>/dev/null || missing+=(libopencv-dev)
[ ${#missing[@]} -gt 0 ] || exit 0
command -v apt-get >/dev/null 2>&1 || fail "no apt-get: install ${missing[*]} with your package manager and try again"
echo "installing the packages ${missing[*]}"
sudo=; [ "$(id -u)" = 0 ] || sudo=sudo
$sudo apt-get update -qq
$sudo env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
