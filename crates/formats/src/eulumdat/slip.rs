//! Where a block of planes slips: one value missing or one too many.
//!
//! After the slip every plane is read one angle too early or too late, so neighbouring planes no longer agree and a
//! plane no longer runs smoothly. The place that makes the whole block smoothest again is where the damage is.

/// Blocks larger than this are not searched.
const LARGEST: usize = 80_000;

/// Index of the value that repeats the one before it and that is one too many.
pub(super) fn doubled(values: &[f64], ng: usize) -> Option<usize> {
    if values.len() > LARGEST || ng < 3 {
        return None;
    }
    let candidates: Vec<usize> = (1..values.len()).filter(|&at| values[at] == values[at - 1]).collect();
    if candidates.len() > 400 {
        return None;
    }
    let cost = |at: usize| roughness(values.len() - 1, ng, |index| values[index + usize::from(index >= at)]);
    best(candidates.into_iter(), cost)
}

/// Index before which a value is missing.
pub(super) fn missing(values: &[f64], ng: usize) -> Option<usize> {
    if values.len() > LARGEST || ng < 3 || values.len() < 3 {
        return None;
    }
    let cost = |at: usize| {
        let filled = match at {
            0 => values[0],
            at if at == values.len() => values[at - 1],
            at => 0.5 * (values[at - 1] + values[at]),
        };
        roughness(values.len() + 1, ng, |index| match index.cmp(&at) {
            std::cmp::Ordering::Less => values[index],
            std::cmp::Ordering::Equal => filled,
            std::cmp::Ordering::Greater => values[index - 1],
        })
    };
    let planes = values.len().div_ceil(ng);
    let plane = best(0..planes, |plane| cost((plane * ng + ng / 2).min(values.len())))?;
    let (from, to) = (plane.saturating_sub(1) * ng, ((plane + 2) * ng).min(values.len() + 1));
    best(from..to, cost)
}

fn best(candidates: impl Iterator<Item = usize>, cost: impl Fn(usize) -> f64) -> Option<usize> {
    candidates
        .map(|at| (at, cost(at)))
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(at, _)| at)
}

/// Sum of the second differences along γ and of the differences between planes.
fn roughness(count: usize, ng: usize, value: impl Fn(usize) -> f64) -> f64 {
    let mut sum = 0.0;
    for plane in 0..count / ng {
        let first = plane * ng;
        for index in first + 1..first + ng - 1 {
            sum += (value(index - 1) - 2.0 * value(index) + value(index + 1)).abs();
        }
        if plane > 0 {
            for index in first..first + ng {
                sum += (value(index) - value(index - ng)).abs();
            }
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slip_is_found_where_it_was_made() {
        let ng = 19;
        let block: Vec<f64> = (0..7 * ng)
            .map(|index| {
                let gamma = ((index % ng) as f64 * 5.0).to_radians();
                1000.0 * gamma.cos().max(0.0).powf(1.5) + 3.0 * (index / ng) as f64 * gamma.sin()
            })
            .collect();
        for at in [5, 40, 66, 100, 120] {
            let mut cut = block.clone();
            cut.remove(at);
            assert!(missing(&cut, ng).unwrap().abs_diff(at) <= 1, "{at}");
            let mut twice = block.clone();
            twice.insert(at, block[at]);
            assert_eq!(doubled(&twice, ng), Some(at + 1));
        }
    }
}
