#!/usr/bin/env bash
# The part of route-a.sh that runs in the emulated machine: TOP is the repository.
set -euo pipefail
cd "$1"
export HOME=/tmp TMPDIR=/tmp
isolux=target/debug/isolux
client=target/debug/isolux-usb-client
step() { echo "== $*"; }
wait_for() { for _ in $(seq 300); do "$@" && return; sleep 0.1; done; echo "in vain: $*" >&2; return 1; }
fails() { "$@" && { echo "should have failed: $*" >&2; return 1; }; return 0; }
plugged() { grep -qsx "$1" /sys/bus/usb/devices/*/idProduct; }
unplugged() { ! plugged "$1"; }

# instrument DRIVER PRODUCT VHCI-PORT TCP-PORT
instrument() {
  local driver=$1 product=$2 at=$3 port=$4
  step "$driver: hotplug"
  "$isolux" virtual spectroradiometer --spectroradiometer "$driver" --usbip "$port" --lasts-s 3600 > "/tmp/$driver" &
  wait_for grep -q attach "/tmp/$driver"
  python3 tests/interoperability/route_a.py attach "$port" "$at"
  wait_for plugged "$product"
  "$isolux" devices | grep "2457:$product"
  step "$driver: one spectrum"
  echo "read $driver:usb: 20" | "$client" | tee "/tmp/$driver.first" | cut -c1-100
  grep -qv error "/tmp/$driver.first"
  step "$driver: reset, then another spectrum"
  python3 tests/interoperability/route_a.py reset "$product"
  echo "read $driver:usb: 20" | "$client" | cut -c1-100 | tee /tmp/again
  grep -qv error /tmp/again
  step "$driver: another program has claimed it"
  python3 tests/interoperability/route_a.py claim "$product" /tmp/claimed &
  local claimer=$!
  wait_for test -e /tmp/claimed
  echo "read $driver:usb: 20" | "$client" | tee /tmp/claim
  grep -q error /tmp/claim
  kill "$claimer"; wait "$claimer" || true
  rm /tmp/claimed
  echo "read $driver:usb: 20" | "$client" | cut -c1-100 | tee /tmp/again
  grep -qv error /tmp/again
  step "$driver: unplugged, and plugged in again"
  echo "$at" > /sys/devices/platform/vhci_hcd.0/detach
  wait_for unplugged "$product"
  echo "read $driver:usb: 20" | "$client" | tee /tmp/gone
  grep -q error /tmp/gone
  python3 tests/interoperability/route_a.py attach "$port" "$at"
  wait_for plugged "$product"
  echo "read $driver:usb: 20" | "$client" | cut -c1-100 | tee /tmp/again
  grep -qv error /tmp/again
}

instrument ocean-ooi 101e 0 3240
instrument ocean-obp 4000 1 3241
step "everything holds"
