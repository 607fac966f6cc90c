//! A sensor that is full meets the light that is there, wherever the readings put what the model knows.

use nalgebra::DVector;

use crate::forward::{Forward, Hypothesis, Searchable};
use crate::known::Known;
use crate::reference::Errors;

/// A model that is read out where the readings put what it knows of itself.
///
/// Its predictions are still those of the model as it stands, so that `change` stays an error that rows share; but the
/// level at which a sensor is full meets the light that is there.
pub struct ReadOut<'a> {
    /// The model.
    pub forward: &'a dyn Forward,
    /// [`Moved::change`](crate::known::Moved::change) or
    /// [`expected_change`](crate::known::expected_change); empty where nothing is changed.
    pub change: &'a DVector<f64>,
}

impl Forward for ReadOut<'_> {
    fn nuisances(&self) -> usize {
        self.forward.nuisances()
    }

    fn nuisance_weights(&self) -> Vec<f64> {
        self.forward.nuisance_weights()
    }

    fn shape_terms(&self) -> Vec<Option<usize>> {
        self.forward.shape_terms()
    }

    fn common_errors(&self) -> Errors {
        self.forward.common_errors()
    }

    fn known(&self) -> Vec<Known> {
        self.forward.known()
    }

    fn effects(&self) -> &[Searchable] {
        self.forward.effects()
    }

    fn read_out(&self, effect: usize, amplitude: f64, prediction: &DVector<f64>) -> Option<DVector<f64>> {
        if self.change.is_empty() {
            return self.forward.read_out(effect, amplitude, prediction);
        }
        let there = prediction + self.change;
        Some(self.forward.read_out(effect, amplitude, &there)? - self.change)
    }

    fn predict(&self, nuisance: &[f64], hypotheses: &[Hypothesis]) -> Option<DVector<f64>> {
        let (last, before): (Vec<_>, Vec<_>) = hypotheses
            .iter()
            .cloned()
            .partition(|one| self.effects()[one.effect].one_by_one);
        let mut prediction = self.forward.predict(nuisance, &before)?;
        for one in last {
            prediction = match self.read_out(one.effect, one.linear[0], &prediction) {
                Some(read) => read,
                None => return self.forward.predict(nuisance, hypotheses),
            };
        }
        Some(prediction)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Light of 1 on every row, and a sensor that is full at the amplitude of its one effect.
    struct Full([Searchable; 1]);

    impl Forward for Full {
        fn nuisances(&self) -> usize {
            0
        }

        fn effects(&self) -> &[Searchable] {
            &self.0
        }

        fn read_out(&self, _: usize, amplitude: f64, prediction: &DVector<f64>) -> Option<DVector<f64>> {
            Some(prediction.map(|light| light.min(amplitude)))
        }

        fn predict(&self, _: &[f64], _: &[Hypothesis]) -> Option<DVector<f64>> {
            Some(DVector::from_element(3, 1.0))
        }
    }

    #[test]
    fn a_full_sensor_meets_the_light_that_is_there() {
        let effect = Searchable {
            name: "saturation",
            step: vec![0.9],
            step_share: Vec::new(),
            plausible: vec![1.5],
            least: 0.0,
            limits: vec![(0.0, f64::INFINITY)],
            turns: false,
            one_by_one: true,
            period_of_signal: false,
            chosen_from: 0,
            one_sided: true,
            never_negative: false,
            shapes: vec![Vec::new()],
            bounds: Vec::new(),
            assumed: Vec::new(),
            shape_step: Vec::new(),
            oscillates: None,
            fixed: Vec::new(),
        };
        let forward = Full([effect]);
        let change = DVector::from_vec(vec![-0.3, 0.0, 0.3]);
        let read_out = ReadOut {
            forward: &forward,
            change: &change,
        };
        let full = Hypothesis {
            effect: 0,
            linear: vec![0.9],
            shape: Vec::new(),
        };
        // The light that is there is 0.7, 1 and 1.3; the sensor shows 0.7, 0.9 and 0.9.
        let expected = DVector::from_vec(vec![0.7, 0.9, 0.9]) - &change;
        assert!((read_out.predict(&[], &[full]).unwrap() - expected).amax() < 1e-12);
        assert_eq!(read_out.predict(&[], &[]).unwrap(), DVector::from_element(3, 1.0));
    }
}
