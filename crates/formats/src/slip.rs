//! Where a block of planes slips: values missing, or some too many.
//!
//! After the slip every plane is read too early or too late, so neighbouring planes no longer agree and a plane no
//! longer runs smoothly. The place that makes the whole block smoothest again is where the damage is.

/// Most terms that a search adds up; larger blocks are not searched.
const MOST_TERMS: usize = 60_000_000;

/// Which of `candidates` (rising indices) begins the `width` values that are too many.
pub(crate) fn extra(values: &[f64], ng: usize, width: usize, candidates: &[usize]) -> Option<usize> {
    let count = values.len().checked_sub(width)?;
    search(candidates, count, ng, |at| {
        roughness(count, ng, |index| {
            values[if index < at { index } else { index + width }]
        })
    })
}

/// Which of `candidates` (rising indices) follows directly on the `width` values that are missing.
pub(crate) fn missing(values: &[f64], ng: usize, width: usize, candidates: &[usize]) -> Option<usize> {
    let count = values.len() + width;
    search(candidates, count, ng, |at| {
        // Whole lines are filled from the planes beside, single values from the values beside.
        let reach = if width > 1 { ng } else { 1 };
        let fill = |index: usize| {
            let (low, high) = (
                index.checked_sub(reach),
                Some(index + reach).filter(|&high| high < count),
            );
            let stands = |index: usize| {
                if index < at {
                    Some(values[index])
                } else {
                    index
                        .checked_sub(width)
                        .filter(|&index| index >= at)
                        .map(|index| values[index])
                }
            };
            match (low.and_then(stands), high.and_then(stands)) {
                (Some(low), Some(high)) => 0.5 * (low + high),
                (Some(only), None) | (None, Some(only)) => only,
                (None, None) => 0.0,
            }
        };
        roughness(count, ng, |index| {
            if index < at {
                values[index]
            } else if index < at + width {
                fill(index)
            } else {
                values[index - width]
            }
        })
    })
}

/// The candidate of least cost: all of them, or one a plane and then those around the best, where they are many.
fn search(candidates: &[usize], count: usize, ng: usize, cost: impl Fn(usize) -> f64) -> Option<usize> {
    if ng < 3 || count < ng {
        return None;
    }
    // Of equals the last: files lose their end more often than their middle.
    let best = |some: &mut dyn Iterator<Item = usize>| {
        some.map(|at| (at, cost(at)))
            .max_by(|a, b| b.1.total_cmp(&a.1))
            .map(|(at, _)| at)
    };
    let budget = MOST_TERMS / count;
    if candidates.len() <= budget {
        return best(&mut candidates.iter().copied());
    }
    let mut coarse: Vec<usize> = candidates.to_vec();
    coarse.dedup_by_key(|at| *at / ng);
    if coarse.len() + 3 * ng > budget {
        return None;
    }
    let plane = best(&mut coarse.into_iter())? / ng;
    let near = candidates.iter().copied().filter(|&at| (at / ng).abs_diff(plane) <= 1);
    best(&mut near.into_iter())
}

/// Sum of the second differences along γ and of those between planes.
fn roughness(count: usize, ng: usize, value: impl Fn(usize) -> f64) -> f64 {
    let mut sum = 0.0;
    for plane in 0..count / ng {
        let first = plane * ng;
        let (mut before, mut this) = (value(first), value(first + 1));
        for index in first + 2..first + ng {
            let next = value(index);
            sum += (before - 2.0 * this + next).abs();
            (before, this) = (this, next);
        }
        for index in first..first + ng {
            match plane {
                0 => {}
                1 => sum += (value(index) - value(index - ng)).abs(),
                _ => sum += (value(index) - 2.0 * value(index - ng) + value(index - 2 * ng)).abs(),
            }
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    const NG: usize = 19;

    fn block() -> Vec<f64> {
        (0..7 * NG)
            .map(|index| {
                let gamma = ((index % NG) as f64 * 5.0).to_radians();
                1000.0 * gamma.cos().max(0.0).powf(1.5) + 3.0 * (index / NG) as f64 * gamma.sin()
            })
            .collect()
    }

    #[test]
    fn one_value_is_found_where_it_was_lost_or_doubled() {
        let block = block();
        for at in [5, 40, 66, 100, 120] {
            let mut cut = block.clone();
            cut.remove(at);
            let all: Vec<usize> = (0..=cut.len()).collect();
            assert!(missing(&cut, NG, 1, &all).unwrap().abs_diff(at) <= 1, "{at}");
            let mut twice = block.clone();
            twice.insert(at, block[at]);
            let equal: Vec<usize> = (1..twice.len()).filter(|&at| twice[at] == twice[at - 1]).collect();
            assert_eq!(extra(&twice, NG, 1, &equal), Some(at + 1));
        }
    }

    #[test]
    fn a_line_of_several_values_is_found() {
        let block = block();
        let lines: Vec<usize> = (0..block.len()).filter(|at| at % NG == 0 || at % NG == 10).collect();
        for &at in &lines[1..lines.len() - 1] {
            let width = if at % NG == 0 { 10 } else { 9 };
            let mut cut = block.clone();
            cut.drain(at..at + width);
            let starts: Vec<usize> = lines.iter().map(|&l| if l > at { l - width } else { l }).collect();
            let mut starts: Vec<usize> = starts.into_iter().filter(|&l| l <= cut.len()).collect();
            starts.dedup();
            assert_eq!(missing(&cut, NG, width, &starts), Some(at));
        }
    }
}
