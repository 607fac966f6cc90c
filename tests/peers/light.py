"""Peers of the light solvers on the published scene, beside our own, in one run: medians and ratios.

    tests/peers/light.sh            installs numpy, Mitsuba 3 and Dr.Jit into a virtual environment and runs this

Our maps are written into memory that is used again, as Dr.Jit's allocator does.
All programs read the same table of intensities (24 planes, 91 polar angles) and use two threads. Error: largest relative
deviation from the reference map (every pixel integrated by itself in f64).
"""
import json, os, statistics, subprocess, sys, time

import numpy as np

THREADS, PIXELS, SIZE, DISTANCE, FLUX = 2, 2048, 24.576, 500.0, 337.0
bench, folder, rounds = sys.argv[1], sys.argv[2], int(sys.argv[3]) if len(sys.argv) > 3 else 3
times, errors, bounds = {}, {}, {}


def ours():
    text = subprocess.run([bench, "5"], check=True, capture_output=True, text=True,
                          env=dict(os.environ, RAYON_NUM_THREADS=str(THREADS), ISOLUX_LIGHT_FOLDER=folder)).stdout
    for line in text.splitlines():
        entry = json.loads(line)
        if "bound" in entry:
            bounds[f"isolux inverse {entry['bound']}"] = entry["largest"]
        else:
            times.setdefault("isolux " + entry["name"], []).extend(entry["seconds"])


def timed(name, work, repetitions=7):
    work()
    for _ in range(repetitions):
        start = time.perf_counter()
        work()
        times.setdefault(name, []).append(time.perf_counter() - start)


ours()
table = np.fromfile(folder + "/table.f64").reshape(24, 91)
reference = {kind: np.fromfile(f"{folder}/reference-{kind}.f64").reshape(-1, PIXELS) for kind in ("point", "disc")}


def error(name, map_, kind):
    errors[name] = float(np.abs(np.asarray(map_, dtype=float).reshape(PIXELS, PIXELS)[::64] / reference[kind] - 1).max())


for kind in ("point", "disc"):
    error(f"isolux inverse {kind}", np.fromfile(f"{folder}/ours-{kind}.f64"), kind)


# ---- numpy, float32, pixel centres, point ----
def numpy_map():
    x = ((np.arange(PIXELS, dtype=np.float32) + 0.5) * (SIZE / PIXELS) - SIZE / 2).astype(np.float32)
    xx, yy = x[None, :], x[:, None]
    axis = xx * xx + yy * yy
    square = axis + np.float32(DISTANCE**2)
    gamma = np.arctan2(np.sqrt(axis), np.float32(DISTANCE)) * np.float32(180 / np.pi)
    c = np.mod(np.arctan2(yy, xx) * np.float32(12 / np.pi), np.float32(24))
    ig, ic = gamma.astype(np.int32), np.minimum(c.astype(np.int32), 23)
    t, u = gamma - ig, c - ic
    flat = np.vstack([table, table[:1]]).astype(np.float32).ravel()
    at = ic * 91 + ig
    low = flat[at] * (1 - t) + flat[at + 1] * t
    high = flat[at + 91] * (1 - t) + flat[at + 92] * t
    return (low + u * (high - low)) * (np.float32(1e6 * DISTANCE) / (square * np.sqrt(square)))


error("numpy map", numpy_map(), "point")
timed("numpy map", numpy_map, 5)

import drjit as dr
import mitsuba as mi

mi.set_variant("llvm_ad_rgb")
from drjit.llvm import Float, PCG32, UInt32  # noqa: E402

dr.set_thread_count(THREADS)
flat_table = Float(np.vstack([table, table[:1]]).astype(np.float32).ravel())


# ---- Dr.Jit, map kernel written by hand, float32, pixel centres: a point, and the disc by 7 points (degree 5) ----
SEVEN = [(0.25, 0.0, 0.0)] + [(0.125, 0.5 * (2 / 3) ** 0.5 * np.cos(k * np.pi / 3), 0.5 * (2 / 3) ** 0.5 * np.sin(k * np.pi / 3)) for k in range(6)]


def drjit_map(spots):
    index = dr.arange(UInt32, PIXELS * PIXELS)
    px = (Float(index % PIXELS) + 0.5) * (SIZE / PIXELS) - SIZE / 2
    py = (Float(index // PIXELS) + 0.5) * (SIZE / PIXELS) - SIZE / 2
    out = Float(0)
    for weight, dx, dy in spots:
        x, y = px - float(dx), py - float(dy)
        axis = dr.fma(x, x, y * y)
        square = axis + DISTANCE**2
        gamma = dr.atan2(dr.sqrt(axis), Float(DISTANCE)) * (180 / dr.pi)
        c = dr.atan2(y, x) * (12 / dr.pi)
        c = dr.select(c < 0, c + 24, c)
        ig, ic = UInt32(gamma), dr.minimum(UInt32(c), 23)
        t, u = gamma - Float(ig), c - Float(ic)
        at = ic * 91 + ig
        a, b = dr.gather(Float, flat_table, at), dr.gather(Float, flat_table, at + 1)
        d, e = dr.gather(Float, flat_table, at + 91), dr.gather(Float, flat_table, at + 92)
        low, high = dr.fma(t, b - a, a), dr.fma(t, e - d, d)
        out += dr.fma(u, high - low, low) * (weight * 1e6 * DISTANCE) / (square * dr.sqrt(square))
    dr.eval(out)
    dr.sync_thread()
    return out


def drjit_maps():
    timed("Dr.Jit map kernel", lambda: drjit_map([(1.0, 0.0, 0.0)]))
    timed("Dr.Jit disc kernel", lambda: drjit_map(SEVEN))


error("Dr.Jit map kernel", np.array(drjit_map([(1.0, 0.0, 0.0)])), "point")
error("Dr.Jit disc kernel", np.array(drjit_map(SEVEN)), "disc")
drjit_maps()

# ---- Dr.Jit, rays written by hand: cell by inverse CDF, linear within γ, disc of 1 mm, count by pixel ----
gammas = np.radians(np.arange(91.0))
low, high = table[:, :-1], table[:, 1:]
flux = (0.5 * (low + high)) * (np.cos(gammas[:-1]) - np.cos(gammas[1:]))[None, :]
cumulative = np.cumsum(flux.ravel()) / flux.sum()
STEPS = 1 << 15
guide = UInt32(np.searchsorted(cumulative, (np.arange(STEPS) + 0.5) / STEPS).clip(0, flux.size - 1).astype(np.uint32))
cosines = Float(np.cos(gammas).astype(np.float32))
RAYS = 1 << 25


def drjit_rays(seed):
    rng = PCG32(size=RAYS, initstate=seed)
    cell = dr.gather(UInt32, guide, dr.minimum(UInt32(rng.next_float32() * STEPS), STEPS - 1))
    ic, ig = cell // 90, cell % 90
    near, far = dr.gather(Float, cosines, ig), dr.gather(Float, cosines, ig + 1)
    z = dr.fma(rng.next_float32(), far - near, near)
    s = dr.sqrt(dr.abs(1 - z * z))
    sin, cos = dr.sincos((Float(ic) + rng.next_float32()) * (dr.pi / 12))
    radius = 0.5 * dr.sqrt(rng.next_float32())
    osin, ocos = dr.sincos(rng.next_float32() * (2 * dr.pi))
    reach = DISTANCE / z
    x = (dr.fma(s * cos, reach, radius * ocos) + SIZE / 2) * (PIXELS / SIZE)
    y = (dr.fma(s * sin, reach, radius * osin) + SIZE / 2) * (PIXELS / SIZE)
    inside = (z > 0) & (x >= 0) & (y >= 0) & (x < PIXELS) & (y < PIXELS)
    count = dr.zeros(UInt32, PIXELS * PIXELS)
    dr.scatter_reduce(dr.ReduceOp.Add, count, UInt32(1), UInt32(y) * PIXELS + UInt32(x), inside)
    dr.eval(count)
    dr.sync_thread()
    return count


share = float(np.array(drjit_rays(1), dtype=float).sum()) / RAYS
expected = float(reference["disc"].mean()) * (SIZE * 1e-3) ** 2 / FLUX
print(f"Dr.Jit rays on the sensor: {share:.6f} of all, expected {expected:.6f}", file=sys.stderr)
timed("Dr.Jit ray kernel", lambda: drjit_rays(7))

# ---- Mitsuba, direct estimator on a white rectangle, spot emitter, one sample a pixel ----
# A texture carries what 91 polar angles say, within 2.5°: bitmap over the spot's own cone.
HALF = 2.5
SIDE = 512
edge = np.tan(np.radians(HALF)) * ((np.arange(SIDE) + 0.5) / SIDE * 2 - 1)
px, py = np.meshgrid(edge, edge)
g = np.degrees(np.arctan(np.hypot(px, py))).clip(0, 89.99)
c = np.mod(np.degrees(np.arctan2(py, px)) / 15, 24)
ig, ic = g.astype(int), np.minimum(c.astype(int), 23)
full = np.vstack([table, table[:1]])
t, u = g - ig, c - ic
values = ((full[ic, ig] * (1 - t) + full[ic, ig + 1] * t) * (1 - u) + (full[ic + 1, ig] * (1 - t) + full[ic + 1, ig + 1] * t) * u)
scene = mi.load_dict({
    "type": "scene",
    "integrator": {"type": "direct", "emitter_samples": 1, "bsdf_samples": 0},
    "lamp": {"type": "spot", "to_world": mi.ScalarTransform4f().look_at([0, 0, 0], [0, 0, 1], [0, 1, 0]), "cutoff_angle": HALF,
             "beam_width": HALF - 1e-3, "intensity": {"type": "rgb", "value": 1.0},
             "texture": {"type": "bitmap", "raw": True, "filter_type": "bilinear",
                         "bitmap": mi.Bitmap(np.repeat(values[:, :, None], 3, axis=2).astype(np.float32))}},
    "plane": {"type": "rectangle", "to_world": mi.ScalarTransform4f().translate([0, 0, DISTANCE]) @ mi.ScalarTransform4f().rotate([0, 1, 0], 180) @ mi.ScalarTransform4f().scale(SIZE),
              "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 1.0}}},
    "camera": {"type": "orthographic",
               "to_world": mi.ScalarTransform4f().look_at([0, 0, 1], [0, 0, DISTANCE], [0, 1, 0]) @ mi.ScalarTransform4f().scale([SIZE / 2, SIZE / 2, 1]),
               "film": {"type": "hdrfilm", "width": PIXELS, "height": PIXELS, "rfilter": {"type": "box"}, "pixel_format": "luminance", "component_format": "float32"},
               "sampler": {"type": "independent", "sample_count": 1}},
})


def mitsuba_direct():
    image = mi.render(scene, spp=1)
    dr.eval(image)
    dr.sync_thread()
    return image


image = np.array(mitsuba_direct())[:, :, 0] * np.pi * 1e6
flips = [image, image[:, ::-1], image[::-1], image[::-1, ::-1]]
best = min(flips, key=lambda m: np.abs(m[::64] / reference["point"] - 1).max())
error("Mitsuba direct", best, "point")
timed("Mitsuba direct", mitsuba_direct)

for _ in range(rounds - 1):
    ours()
    timed("numpy map", numpy_map, 3)
    drjit_maps()
    timed("Dr.Jit ray kernel", lambda: drjit_rays(7))
    timed("Mitsuba direct", mitsuba_direct)

median = {name: statistics.median(values) for name, values in times.items()}
print(f"{'what':26} {'median':>10} {'best':>10} {'largest error':>14}")
for name, value in median.items():
    shown = f"{errors[name]:14.1e}" if name in errors else ""
    if name in bounds:
        shown += f" (stated: {bounds[name]:.1e})"
    print(f"{name:26} {value * 1e3:7.2f} ms {min(times[name]) * 1e3:7.2f} ms {shown}")
traced, peer = 1e8 / median["isolux traced 1e8"], RAYS / median["Dr.Jit ray kernel"]
print(f"\nrays a second: isolux traced {traced / 1e6:.0f} M, Dr.Jit kernel {peer / 1e6:.0f} M")
print("\nratios of medians (goal)")
for kind, kernel in (("point", "map"), ("disc", "disc")):
    mine = median[f"isolux inverse {kind}"]
    print(f"  inverse {kind:9}: Mitsuba direct / isolux {median['Mitsuba direct'] / mine:6.1f} (20) · "
          f"Dr.Jit {kernel} kernel / isolux {median[f'Dr.Jit {kernel} kernel'] / mine:5.1f} (1) · numpy / isolux {median['numpy map'] / mine:6.1f}")
print(f"  traced: isolux / Dr.Jit kernel {traced / peer:.2f} (2)")
print(f"  thinned 2e9 rays: {median['isolux thinned 2e9'] * 1e3:.0f} ms (200)")
