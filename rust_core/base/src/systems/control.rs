//! Step-size control by an estimated error e, in units of the tolerance. The next step is s h e^(α/k) e₀^(β/k), with the safety
//! factor s and the error e₀ of the previous step.

/// Coefficients of a step-size control.
#[derive(Debug, Clone, Copy)]
pub struct Control {
    /// Order k: the estimate is O(hᵏ).
    pub order: u32,
    /// Safety factor s.
    pub safety: f64,
    /// Exponents α and β.
    pub exponents: [f64; 2],
    /// Minimum and maximum ratio of successive steps.
    pub ratios: [f64; 2],
    /// Range to which errors are limited; beyond it the step changes by the minimum or the maximum ratio.
    pub errors: [f64; 2],
    /// Largest error of an accepted step.
    pub accepted: f64,
}

impl Control {
    /// Control of an embedded pair: a PI controller, which does not oscillate where stability limits the step.
    ///
    /// Sources: E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed. (1993), II.4; K.
    /// Gustafsson, ACM Trans. Math. Softw. 17 (1991) 533; G. Söderlind, Numer. Algorithms 31 (2002) 281.
    pub fn pair(order: u32) -> Self {
        Self { order, safety: 0.9, exponents: [-0.7, 0.4], ratios: [0.2, 5.0], errors: [1e-4, 1e4], accepted: 1.0 }
    }

    /// Control of IAS15. Its estimate is the last coefficient, far above the error. A step is rejected if the next step would be
    /// less than a quarter of it.
    ///
    /// Source: H. Rein, D. S. Spiegel, Mon. Not. R. Astron. Soc. 446 (2015) 1424, sec. 2.3.
    pub const GAUSS_RADAU: Self = Self {
        order: 7,
        safety: 1.0,
        exponents: [-1.0, 0.0],
        ratios: [0.01, 4.0],
        errors: [1e-5, 1e14],
        accepted: 16384.0, // 4⁷
    };

    /// Ratio of the next step to this one, from the errors of this step and of the previous one.
    pub fn ratio(&self, error: f64, before: f64) -> f64 {
        let [integral, proportional] = self.exponents;
        self.bounded(self.power(error, integral) * self.power(before, proportional))
    }

    /// Ratio of the next trial to a step that was rejected for its error.
    pub fn retry(&self, error: f64) -> f64 {
        self.bounded(self.power(error, -1.0)).min(self.safety)
    }

    fn power(&self, error: f64, exponent: f64) -> f64 {
        libm::pow(error, exponent / f64::from(self.order))
    }

    fn bounded(&self, factor: f64) -> f64 {
        (self.safety * factor).clamp(self.ratios[0], self.ratios[1])
    }
}
