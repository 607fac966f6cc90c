#!/usr/bin/env bash
# Ray files beside TM25RaySetTools, a reader of TM-25 by another hand (J. Muschaweck, public domain): it reads what
# `simulate --rays-out` writes without an error or a warning, and says the same of it, and of a measured LED's file, as `isolux inspect`.
#
#     tests/peers/rays.sh
#
# Needs git, a C++17 compiler and Python 3. Sources are fetched into target/peers/rays; TM25_TOOLS and TM25_FILES name folders to take instead.
set -euo pipefail
cd "$(dirname "$0")/../.."
home=target/peers/rays
mkdir -p "$home"
fetched() { # repository commit
  local folder="$home/${1##*/}"
  if [ ! -e "$folder/README.md" ]; then
    git init -q "$folder"
    git -C "$folder" fetch -q --depth 1 "https://github.com/$1" "$2" >&2
    git -C "$folder" checkout -q FETCH_HEAD
  fi
  echo "$folder"
}
tools="${TM25_TOOLS:-$(fetched JuliusMuschaweck/TM25RaySetTools da51849b9681510b40e88db7a96d7f9cddde79cf)}"
files="${TM25_FILES:-$(fetched LarryBoxler/IESTM25RayFiles a8395ec4af151c6d7257e6e85cc3d0f481d5dad3)}"

# The library is written for another compiler: names that shadow each other and a header that it alone has.
if [ ! -x "$home/dump" ]; then
  rm -rf "$home/library"
  cp -r "$tools/TM25Library" "$home/library"
  sed -i 's/template<typename RayArray> *\r\?$/template<typename Rays_>/; s/= typename RayArray;/= Rays_;/' "$home/library/TM25.h"
  sed -i 's/template< int N>/template<size_t N>/' "$home/library/TM25Util.h"
  : >"$home/library/stdafx.h"
  cat >"$home/dump.cpp" <<'CPP'
#include <TM25.h>
#include <cstdio>
int main(int, char** argv) {
    try {
        TM25::TTM25RaySet set;
        set.Read(argv[1]);
        for (auto const& warning : set.Warnings()) std::fprintf(stderr, "warning: %s\n", warning.c_str());
        double flux = 0, z = 0;
        for (size_t i = 0; i < set.NRays(); ++i) {
            auto [place, direction, ray] = set.RayLocDirFlux(i);
            flux += ray;
            z += static_cast<double>(ray) * direction[2];
        }
        auto box = set.RayArray().BoundingBox();
        std::printf("{\"rays\": %zu, \"flux\": %.9g, \"z\": %.9g, \"min\": [%.9g, %.9g, %.9g], \"max\": [%.9g, %.9g, %.9g]}\n", set.NRays(), flux,
            z / flux, box.first[0], box.first[1], box.first[2], box.second[0], box.second[1], box.second[2]);
        return set.Warnings().empty() ? 0 : 1;
    } catch (std::exception const& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
}
CPP
  (cd "$home" && g++ -std=c++17 -O1 -fpermissive -w -include cmath -include cstring -include array -include cstdint -include limits \
    -Ilibrary dump.cpp library/{TM25,TM25Util,ReadFile,WriteFile}.cpp -o dump)
fi

cargo build --quiet --release -p isolux
isolux=target/release/isolux
work="$home/work"
rm -rf "$work"
mkdir -p "$work"
printf 'gamma_deg,intensity_cd\n0,300\n20,270\n45,150\n70,40\n90,0\n' >"$work/lamp.csv"
printf 'wavelength_nm,value\n400,0\n450,1\n500,0.3\n560,0.9\n620,0.6\n700,0\n' >"$work/lamp.spectrum.csv"
scene() { # what the luminaire adds
  printf 'format = "isolux-scene/1"\n[luminaire]\ndistribution = "lamp.csv"\n%s\nemitter = { shape = "disc", diameter_mm = 8.0 }\n[sensor]\nsize_mm = 60\npixels = 16\ndistance_mm = 100\ntilt_x_deg = 10\n' "$1"
}
scene 'spectrum = "lamp.spectrum.csv"' >"$work/spectral.toml"
scene '' >"$work/plain.toml"
for name in spectral plain; do
  "$isolux" simulate "$work/$name.toml" --out "$work/$name" --rays-out "$work/$name.tm25ray" 20000 >/dev/null
done
for file in "$work/spectral.tm25ray" "$work/plain.tm25ray" "$files"/*.TM25RAY; do
  "$isolux" inspect "$file" --json >"$work/ours.json"
  "$home/dump" "$file" >"$work/theirs.json"
  python3 - "$work/ours.json" "$work/theirs.json" "$file" <<'PY'
import json, sys
ours, theirs = (json.load(open(path)) for path in sys.argv[1:3])
of = ours["quantities"]
flux = of["luminous_flux_lm"] if of["luminous_flux_lm"] is not None else of["radiant_flux_w"]
assert ours["findings"] == [], ours["findings"]
assert of["rays"] == theirs["rays"], (of["rays"], theirs["rays"])
pairs = [(flux, theirs["flux"]), (of["mean_direction"][2], theirs["z"])]
pairs += list(zip(of["bounds_min_mm"] + of["bounds_max_mm"], theirs["min"] + theirs["max"]))
for a, b in pairs:
    assert abs(a - b) <= 2e-6 * max(1.0, abs(a)), (a, b)
print(f"{sys.argv[3]}: {of['rays']} rays, {flux:.6g}, both readers agree; {of['spectral']}")
PY
done
