"""Enumerators of the C++ library. Their names as texts are taken wherever they are.

Arrays of `fit.report` hold their numbers: ``fit.report.status == recon.FitStatus.full``.
"""

import enum


class Solver(enum.IntEnum):
    """How the local least-squares problem is solved; method "mls" is the first, "imls" the second."""

    moment_matrix = 0
    gram_schmidt = 1
    qr = 2
    svd = 3


class FitStatus(enum.IntEnum):
    """What became of a target: `reduced` has a lower degree, and the last two have no value."""

    full = 0
    reduced = 1
    nearest = 2
    no_support = 3
    too_far = 4


class Weight(enum.Enum):
    """The weights w(q), q = distance / support radius; wendland_c0 to c6 and B-splines of degree 1 to 5."""

    linear_b_spline = 0
    quadratic_b_spline = 1
    cubic_b_spline = 2
    quartic_b_spline = 3
    quintic_b_spline = 4
    wendland_c0 = 5
    wendland_c2 = 6
    wendland_c4 = 7
    wendland_c6 = 8
    gaussian = 9
    inverse_distance = 10


class WeightForm(enum.Enum):
    """radial: the support is a ball; tensor_product: a cube."""

    radial = 0
    tensor_product = 1


class SearchMethod(enum.Enum):
    """How neighbours are searched; the results do not depend on it."""

    automatic = 0
    kd_tree = 1
    r_tree = 2
    cell_grid = 3
    brute_force = 4


class Unsupported(enum.Enum):
    """The value of a target without a particle: fill_value, or that of the nearest particle."""

    fill = 0
    nearest = 1


class Derivative(enum.Enum):
    """diffuse: of the local polynomial; exact: of the reconstructed field."""

    diffuse = 0
    exact = 1


class Limit(enum.Enum):
    """range: values stay in the range of the data they are made of; relaxed: near it."""

    none = 0
    range = 1
    relaxed = 2
