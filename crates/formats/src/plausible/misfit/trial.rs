//! Two values exchanged for a moment: the misfits that change, what is usual around them, and whose verdict may differ.

use super::{Field, UNKNOWN, Which, misfit_across};

/// What an exchange changed in a field, and how to take it back.
pub(in crate::plausible) struct Trial {
    /// Values for which the field now says something else than before, in no order.
    pub touched: Vec<usize>,
    marked: Vec<u32>,
    stale: Vec<u32>,
    turn: u32,
    reached: Vec<Which>,
    stale_list: Vec<Which>,
    misfits: Vec<(Which, f32)>,
    usual: Vec<(usize, f32)>,
    exchanged: (usize, usize),
}

impl Trial {
    /// None has been made yet.
    pub fn new(field: &Field) -> Self {
        let count = field.planes * field.ng;
        Self {
            touched: Vec::new(),
            marked: vec![0; count],
            stale: vec![0; 4 * count],
            turn: 0,
            reached: Vec::new(),
            stale_list: Vec::new(),
            misfits: Vec::new(),
            usual: Vec::new(),
            exchanged: (0, 0),
        }
    }

    /// Whether the value is one of the touched.
    pub fn touches(&self, index: usize) -> bool {
        self.marked[index] == self.turn
    }

    /// Exchanges two values.
    pub fn make(&mut self, field: &mut Field, one: usize, other: usize) {
        self.turn += 1;
        self.exchanged = (one, other);
        for list in [&mut self.reached, &mut self.stale_list] {
            list.clear();
        }
        self.touched.clear();
        self.misfits.clear();
        self.usual.clear();
        field.values.swap(one, other);
        field.reached(one, &mut self.reached);
        field.reached(other, &mut self.reached);
        self.reached.sort_unstable();
        self.reached.dedup();
        for at in 0..self.reached.len() {
            let which = self.reached[at];
            let misfit = field.misfit_of(which);
            let slot = &mut field.misfit[usize::from(which.across)][which.order][which.plane * field.ng + which.angle];
            if slot.to_bits() == misfit.to_bits() {
                continue;
            }
            self.misfits.push((which, *slot));
            *slot = misfit;
            self.outdate(field, which);
        }
        for index in [one, other] {
            self.touch(index);
        }
        for at in 0..self.stale_list.len() {
            let which = self.stale_list[at];
            field.near(which, |plane, angle| self.touch(plane * field.ng + angle));
        }
    }

    /// Takes the exchange back.
    pub fn take_back(&mut self, field: &mut Field) {
        field.values.swap(self.exchanged.0, self.exchanged.1);
        for &(which, misfit) in &self.misfits {
            field.misfit[usize::from(which.across)][which.order][which.plane * field.ng + which.angle] = misfit;
        }
        for &(at, usual) in &self.usual {
            field.usual[at].set(usual);
        }
    }

    fn touch(&mut self, index: usize) {
        if self.marked[index] != self.turn {
            self.marked[index] = self.turn;
            self.touched.push(index);
        }
    }

    /// A misfit has changed: so may what is usual wherever it lies in the surroundings ([`Field::around`]).
    fn outdate(&mut self, field: &Field, which: Which) {
        self.note(field, which);
        let Which {
            across,
            order,
            plane,
            angle,
        } = which;
        let mut range = |plane: usize, from: usize, to: usize| {
            for angle in from..to.min(field.ng) {
                let near = Which {
                    across,
                    order,
                    plane,
                    angle,
                };
                self.note(field, near);
            }
        };
        if field.few() {
            for other in (0..field.planes).filter(|&other| other != plane) {
                range(other, angle.saturating_sub(4), angle + 5);
            }
            range(plane, angle.saturating_sub(9), angle + 10);
            return;
        }
        for offset in [-3, -2, -1, 1, 2, 3] {
            if let Some((_, other)) = field.plane(plane as isize + offset).filter(|found| found.1 != plane) {
                range(other, angle.saturating_sub(4), angle + 5);
            }
        }
    }

    fn note(&mut self, field: &Field, which: Which) {
        let at = which.at(field);
        if self.stale[at] != self.turn {
            self.stale[at] = self.turn;
            self.stale_list.push(which);
            self.usual.push((at, field.usual[at].replace(UNKNOWN)));
        }
    }
}

impl Field {
    /// A misfit computed anew.
    fn misfit_of(&self, which: Which) -> f32 {
        let Which {
            across,
            order,
            plane,
            angle,
        } = which;
        let row = self.row(plane);
        if across {
            let aside = self.across[order][plane].map(|aside| aside.map(|(other, weight)| (self.row(other), weight)));
            aside.map_or(f32::NAN, |aside| misfit_across(order, row[angle], &aside, angle))
        } else {
            self.misfit_along(order, row, self.opposite[plane].map(|other| self.row(other)), angle)
        }
    }
}
