"""Columns of `output.history`: what they are, and their units."""
from .quantity import words_of

# Beginnings of the names of fields, and their units: those of the table in docs/output.md.
UNITS = (("displacement_gradient", ""), ("displacement", "m"), ("velocity", "m/s"), ("acceleration", "m/s^2"), ("contact_pressure", "Pa"),
         ("contact_gap", "m"), ("contact_slip", "m/s"), ("membrane_force", "N/m"), ("principal_membrane_force", "N/m"), ("bending_moment", "N"),
         ("principal_bending_moment", "N"), ("principal_curvature", "1/m"), ("rod_force", "N"), ("rod_bending_moment", "N m"),
         ("rod_torque", "N m"), ("principal_stress", "Pa"), ("von_mises_stress", "Pa"), ("cauchy_stress", "Pa"), ("elastic_cauchy_stress", "Pa"),
         ("viscous_cauchy_stress", "Pa"), ("active_cauchy_stress", "Pa"), ("first_piola_kirchhoff_stress", "Pa"), ("energy_density", "J/m^3"),
         ("elastic_energy_density", "J/m^3"), ("viscous_energy_density", "J/m^3"), ("discretization_error", "J/m^3"))
OF_SHELLS = ("membrane_force", "principal_membrane_force", "bending_moment", "principal_bending_moment", "principal_curvature")
# Units of integrals that have a name: of a field, times this power of the metre.
NAMED = {("Pa", 2): "N", ("Pa", 3): "N m", ("J/m^3", 3): "J", ("N/m", 2): "N m"}


def title_of_entry(entry):
    """"integral of first Piola-Kirchhoff stress xx in tip"."""
    of = words_of(entry["of"])
    return f"{of} at {entry['at']}" if "at" in entry else f"{entry['take']} of {of}" + (f" in {entry['in']}" if "in" in entry else "")


def unit_of_field(name):
    return next((unit for beginning, unit in UNITS if name.startswith(beginning)), "")


def _is_surface(given, name):
    """Does any selection of the input choose this surface?"""
    if isinstance(given, dict):
        return given.get("surface") == name or any(_is_surface(value, name) for value in given.values())
    return isinstance(given, list) and any(_is_surface(value, name) for value in given)


def _dimension(given, field, region):
    """The dimension of what a field is integrated over: 3 of volumes, 2 of surfaces, 1 of curves, 0 if the input does not say."""
    if field.startswith(OF_SHELLS):
        return 2
    if field.startswith("rod_"):
        return 1
    volumes, shells = ([entry.get(key) for entry in given.get(part) or []] for part, key in (("bodies", "volume"), ("shells", "name")))
    if region is None:
        return 3 if volumes else 2 if shells else 0
    if region in volumes:
        return 3
    if region in shells or _is_surface(given, region):
        return 2
    return 2 if volumes and None not in volumes else 0  # names of volumes are in the mesh alone where a body is all of it


def unit_of_entry(given, entry):
    """That of a column of `output.history` of an input, as src/study/labelled_history.cpp has it; empty if it has none or is not known."""
    unit, take = unit_of_field(entry["of"]), entry.get("take")
    if "at" in entry or take not in ("integral", "norm"):
        return unit
    dimension = _dimension(given, entry["of"], entry.get("in"))
    if dimension == 0:
        return ""
    power = dimension / 2 if take == "norm" else dimension
    if unit == "m":
        return f"m^{1 + power:g}"
    return NAMED.get((unit, power)) or f"{unit} {'m' if power == 1 else f'm^{power:g}'}".strip()
