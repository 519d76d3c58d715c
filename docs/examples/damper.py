"""Stiffness and loss factor of the pad over the frequency, from the loops of input/damper.yaml, and of the vibration test."""
import sys

import matplotlib
matplotlib.use("svg")
import matplotlib.pyplot as plt
import numpy as np
import pliant

AMPLITUDE, HEIGHT, AREA, PERIODS, STEPS = 0.3e-3, 6e-3, 40e-3 * 20e-3, 3, 40  # [m], [m^2]
frequencies = [float(word) for word in sys.argv[1:]] or [0.1, 1, 10, 100]  # [Hz]

plot, (loops, losses) = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained")
moduli = []
for f in frequencies:
    run = pliant.run("input/damper.yaml", output=f"out/damper_{f:g}", overrides={
        "constraints.plate.displacement": [f"{AMPLITUDE}*sin(2*pi*{f}*t)", 0, 0],
        "time.step": 1 / f / STEPS, "time.end": PERIODS / f, "output.every": 1 / f})
    t, force = (np.asarray(run.history[name])[-STEPS:] for name in ("time", "plate_fx"))  # the last period
    wave = np.exp(-2j * np.pi * f * t)
    shear = AMPLITUDE / HEIGHT * np.sin(2 * np.pi * f * t)
    modulus = force @ wave / AREA / (shear @ wave)  # complex
    moduli.append(modulus)
    print(f"{f:g} Hz: {modulus.real / 1e6:.3f} MPa, loss factor {modulus.imag / modulus.real:.3f}")
    loops.plot(100 * np.append(shear, shear[:1]), np.append(force, force[:1]), label=f"{f:g} Hz")
loops.set(xlabel="shear [%]", ylabel="force [N]")
loops.legend()

f, storage, loss = np.loadtxt("input/data/damping_rubber_dma.csv", delimiter=",", skiprows=3).T
losses.semilogx(f, loss / storage, ".", color="grey", label="vibration test")
losses.semilogx(frequencies, [modulus.imag / modulus.real for modulus in moduli], "o", label="pad")
losses.set(xlabel="frequency [Hz]", ylabel="loss factor")
losses.legend()
plot.savefig("damper.svg")
