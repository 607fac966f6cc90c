//! What counts as noise, and how it is tested: every constant of the test, with what chose it.

/// Scatter up to this many times the stated uncertainty stays noise where no repeats of a
/// pose say otherwise.
pub const SCALE: f64 = 1.25;
/// Serial correlation up to this stays noise where no pose was repeated.
pub const RHO: f64 = 0.5;
/// The combined probability below which what is left is no noise. With the scan's own 0.01 the whole verdict has to
/// stay below 1.5 % of false alarms on white noise and 2 % on AR(1) noise.
pub const SIGNIFICANCE: f64 = 0.003;
/// The permutations get this share of [`SIGNIFICANCE`], the comparison of the scatter with what is stated or repeated
/// another, and both together the rest.
pub const PERMUTED_SHARE: f64 = 0.8;
/// The share of the scatter.
pub const SCATTER_SHARE: f64 = 0.1;
/// Numbers of the strongest tests that are judged together: a change at random times is a little of a period, of a run
/// and of a level of each visit.
pub const TOGETHER: [usize; 2] = [1, 3];
/// Share of the false alarms that the tests for levels of directions, phases of visits and great circles get, against 1
/// of each other one: together less than one of those, which find what benches do more often. By hand.
pub const RARE: f64 = 0.25;
/// Comparisons of the scatter: with what is stated, with repeats of a pose, and from reading to reading; the widest of
/// all readings; and values that come again.
pub const SCATTER_TESTS: f64 = 5.0;
/// Fewer readings that repeat the value before them are chance.
pub const TIES: usize = 4;
/// Up to so many of the widest readings together are compared with outliers.
pub const WIDEST: usize = 4;
/// Outliers that count as noise: this share of the readings, so many times as wide as the others.
pub const OUTLIERS: (f64, f64) = (0.02, 5.0);
/// Residuals count for no more than this many times their robust standard deviation: one wild reading is an outlier,
/// several in one place are still several. With 3.5 a bright patch of three readings, 10 σ together, stayed unseen.
pub const CLIP: f64 = 6.0;
/// The same for squares: with 6, the few largest readings of a loud block made every simulated record loud somewhere,
/// and blocks of 10 σ in all had p = 0.006 and 0.2.
pub const SQUARE_CLIP: f64 = 3.0;
/// Fewer readings than this are not tested, and tell no correlation.
pub const FEWEST: usize = 40;
/// Simulated records, for up to 2,000 rows; fewer for more rows, [`FEWEST_NULLS`] at least. The tail beyond the highest
/// twentieth is an exponential law, so that few are enough.
pub const NULLS: usize = 600;
/// Simulated records at least.
pub const FEWEST_NULLS: usize = 120;
/// Rows times simulated records.
pub const NULL_VALUES: usize = 1_200_000;
/// A reading whose digit makes more than this share of its stated uncertainty is left out: rounding follows the light,
/// it is no noise.
pub const ROUNDED: f64 = 0.3;
/// Every second to every such reading is looked at.
pub const EVERY: usize = 24;
/// The same for visits of half-planes.
pub const EVERY_VISIT: usize = 6;
/// Lengths of runs of successive readings.
pub const RUNS: [usize; 5] = [3, 6, 12, 24, 48];
/// Lengths of parts of the record whose scatter is compared with the others, half overlapping.
pub const PARTS: [usize; 3] = [12, 24, 48];
/// A place without a name must explain this much more than a name (σ²), beside the name's own margin, to take its part:
/// it was looked for at a few thousand places, and 2 ln 3000 is 16, of which the names have a part of their own.
pub const PLACES: f64 = 10.0;
/// Lengths of successive readings whose means are compared.
pub const MEANS: [usize; 4] = [4, 8, 16, 32];
/// Fewer means of readings, pieces of visits, visits with a period or readings of one level are not compared.
pub const FEWEST_PARTS: usize = 8;
/// Readings of nearly the same light whose mean is compared.
pub const ALIKE: usize = 8;
/// Numbers of pieces of each visit of a half-plane whose means are compared.
pub const PIECES: [usize; 3] = [1, 2, 3];
/// Readings in the stretches whose own periods are looked for.
pub const STRETCHES: [usize; 2] = [32, 64];
/// Widths (standard deviations) of patches, in degrees on the sphere.
pub const PATCH_DEG: [f64; 3] = [3.0, 6.0, 12.0];
/// Half-widths (standard deviations) of great circles, in degrees: a wire as wide as a shadow on a head is.
pub const CIRCLE_DEG: [f64; 2] = [2.5, 5.0];
/// Angle between the planes of neighbouring great circles, in degrees: a width of the narrowest at most.
pub const CIRCLES_APART_DEG: f64 = 5.0;
/// Widths of patches on a sensor, as a share of its side.
pub const PATCH_SHARE: [f64; 3] = [0.05, 0.1, 0.2];
/// Directions at most around which a patch is looked for.
pub const CENTRES: usize = 400;
/// Degrees of freedom that repeats of a pose need to decide.
pub const REPEATS: f64 = 10.0;
/// Degrees of freedom that readings of one pose which follow each other need to allow more scatter than stated: they
/// know it to 13 %. With 14 pairs a lucky few let spokes of 1.7 times the stated scatter pass.
pub const REPEATS_AT_ONCE: f64 = 30.0;
/// So many typical steps without a reading are a pause of the record: its neighbours are no neighbours.
pub const PAUSE: f64 = 60.0;
/// Cells of a periodogram at most.
pub const CELLS: usize = 1 << 16;
