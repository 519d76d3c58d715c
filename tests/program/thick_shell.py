"""Long tubes and balls under pressure from inside: the radial equation of a neo-Hookean body, by Runge and Kutta and bisection."""
import dataclasses

import numpy as np


@dataclasses.dataclass
class ThickShell:
    """R dP_r/dR = m (P_t - P_r), P the first Piola-Kirchhoff stress: m = 1 of a tube that keeps its length, 2 of a ball."""
    inner: float  # radii before [m]
    outer: float
    youngs_modulus: float
    poissons_ratio: float
    curved: int  # m

    def stress(self, stretch, other, axial):
        """Along the first of three principal stretches."""
        mu = self.youngs_modulus / 2 / (1 + self.poissons_ratio)
        lame = 2 * mu * self.poissons_ratio / (1 - 2 * self.poissons_ratio)
        return mu * (stretch - 1 / stretch) + lame * np.log(stretch * other * axial) / stretch

    def slopes(self, R, y):
        """Of the radius after and of P_r."""
        radius, traction = y
        hoop = radius / R
        axial = hoop if self.curved == 2 else 1.0
        low, high = 1e-3, 10.0
        for _ in range(60):
            middle = (low + high) / 2
            low, high = (middle, high) if self.stress(middle, hoop, axial) < traction else (low, middle)
        return np.array([low, self.curved * (self.stress(hoop, low, axial) - traction) / R])

    def pressure(self, radius, num_steps=10):
        """That which holds the inner wall at this radius [Pa]."""
        def traction_outside(pressure):
            h = (self.outer - self.inner) / num_steps
            y = np.array([radius, -pressure * (radius / self.inner) ** self.curved])
            for R in self.inner + h * np.arange(num_steps):
                a = self.slopes(R, y)
                b = self.slopes(R + h / 2, y + h / 2 * a)
                c = self.slopes(R + h / 2, y + h / 2 * b)
                d = self.slopes(R + h, y + h * c)
                y = y + h / 6 * (a + 2 * b + 2 * c + d)
            return y[1]

        low, high = 0.0, self.youngs_modulus
        for _ in range(30):
            middle = (low + high) / 2
            low, high = (middle, high) if traction_outside(middle) > 0 else (low, middle)
        return low
