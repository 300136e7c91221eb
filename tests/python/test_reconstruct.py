"""Reconstructions, operators and reports on arrays of any layout."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import scipy.sparse
import scipy.sparse.linalg

import recon
from clouds import Array, inner, jittered, linear, quadratic

masked: Any = np.ma.array  # numpy gives it no types


@pytest.mark.parametrize("dimension", [1, 2, 3])
@pytest.mark.parametrize("degree", [0, 1, 2])
def test_polynomials_up_to_the_degree_are_reproduced(dimension: int, degree: int) -> None:
    x, t = jittered(60 if dimension == 1 else 12, dimension), inner(40, dimension)
    fit = recon.reconstruct(x, t, degree=degree)
    assert fit.shape == (40, len(x)) and fit.dimension == dimension
    field = [lambda p: np.ones(len(p)), linear, quadratic][degree]
    np.testing.assert_allclose(fit @ field(x), field(t), rtol=1e-10)
    assert (fit.report.degree == degree).all()
    assert (fit.report.status == recon.FitStatus.full).all()


def test_shapes_of_values_are_kept() -> None:
    x, t = jittered(10, 2), inner(7, 2)
    fit = recon.reconstruct(x, t)
    u = linear(x)
    tensor = np.random.default_rng(3).normal(size=(len(x), 2, 3))
    assert (fit @ u).shape == (7,)
    assert (fit @ u[:, None]).shape == (7, 1)
    assert (fit @ np.stack([u, u, u, u], axis=1)).shape == (7, 4)
    assert (fit @ tensor).shape == (7, 2, 3)
    np.testing.assert_array_equal((fit @ tensor)[:, 1, 2], fit @ tensor[:, 1, 2])
    assert (fit.T @ np.ones(7)).shape == (100,)
    assert (fit.T @ np.ones((7, 3))).shape == (100, 3)
    assert (fit.gradient() @ u).shape == (7, 2)
    assert (fit.gradient() @ tensor).shape == (7, 2, 3, 2)
    assert (fit.hessian() @ u).shape == (7, 3)
    assert (fit.laplacian() @ tensor).shape == (7, 2, 3)
    assert (fit.divergence() @ tensor[:, :, 0]).shape == (7,)
    assert (fit.strain_rate() @ tensor[:, :, 0]).shape == (7, 3)
    assert (fit.curl() @ tensor[:, :, 0]).shape == (7,)
    x3 = jittered(6, 3)
    assert (recon.reconstruct(x3, inner(5, 3)).curl() @ x3).shape == (5, 3)


def test_gradients_of_each_component_are_behind_it() -> None:
    x, t = jittered(10, 3), inner(20, 3)
    fit = recon.reconstruct(x, t, degree=1)
    slopes = np.random.default_rng(4).normal(size=(4, 3))
    kinds: list[str | recon.Derivative] = ["exact", recon.Derivative.diffuse]
    for kind in kinds:
        np.testing.assert_allclose(
            fit.gradient(kind) @ (x @ slopes.T), np.broadcast_to(slopes, (20, 4, 3)), atol=1e-9
        )


@pytest.mark.parametrize("name", ["values", "gradient", "hessian", "laplacian", "divergence", "strain_rate"])
def test_transposes_are_adjoint(name: str) -> None:
    x, t = jittered(10, 2), inner(30, 2)
    fit = recon.reconstruct(x, t, degree=2)
    op = fit.values if name == "values" else getattr(fit, name)()
    random = np.random.default_rng(5)
    u = random.normal(size=(len(x), 2) if name in ("divergence", "strain_rate") else len(x))
    f = random.normal(size=(op @ u).shape)
    left, right = np.sum((op @ u) * f), np.sum(u * (op.T @ f).reshape(u.shape))
    assert left == pytest.approx(right, rel=1e-11)
    assert op.T.shape == op.shape[::-1] and op.T.T.shape == op.shape


def test_every_layout_gives_the_same_bits() -> None:
    x, t = jittered(12, 3), inner(50, 3)
    u = np.random.default_rng(6).normal(size=(len(x), 3))
    expected = recon.reconstruct(x, t) @ u
    wide = np.zeros((len(x), 9))
    wide[:, 1:9:3] = x
    records = np.zeros(len(x), dtype=[("m", "f4"), ("x", "f8", 3), ("v", "f8", 3), ("c", "i1")])
    records["x"], records["v"] = x, u
    aligned = np.zeros(len(x), dtype=np.dtype([("m", "f4"), ("x", "f8", 3), ("v", "f8", 3)], align=True))
    aligned["x"], aligned["v"] = x, u
    views: list[tuple[Any, Any]] = [
        (np.asfortranarray(x), np.asfortranarray(u)),
        (wide[:, 1:9:3], u[:, ::-1][:, ::-1]),
        ((x[:, 0], x[:, 1].copy(), wide[:, 7]), (u[:, 0], u[:, 1], u[:, 2])),
        (tuple(x.T.copy()), tuple(u.T.copy())),
        (records["x"], records["v"]),  # not aligned
        (aligned["x"], aligned["v"]),
        (x.astype(">f8"), u.astype(">f8")),
        (x.tolist(), u.tolist()),
        (np.repeat(x, 2, axis=0)[::2], np.repeat(u, 2, axis=0)[::2]),
    ]
    for points, field in views:
        np.testing.assert_array_equal(recon.reconstruct(points, t) @ field, expected)
    backwards = recon.reconstruct(x[::-1], t) @ u[::-1]
    np.testing.assert_allclose(backwards, expected, rtol=1e-12, atol=1e-12)


def test_precision_is_that_of_the_points() -> None:
    x, t = jittered(12, 2), inner(20, 2)
    single = recon.reconstruct(x.astype("f4"), t.astype("f4"))
    assert single.dtype == np.float32 and (single @ linear(x)).dtype == np.float32
    np.testing.assert_allclose(single @ linear(x), linear(t), rtol=1e-4)
    assert recon.reconstruct(x.astype("f4"), t).dtype == np.float64  # neither loses digits
    assert recon.reconstruct(x, t.astype("f4")).dtype == np.float64
    sources = recon.Sources(x.astype("f4"))
    assert sources.dtype == np.float32
    assert (recon.reconstruct(sources, t).gradient() @ x).dtype == np.float32
    assert recon.Sources(np.arange(12).reshape(6, 2)).dtype == np.float64
    assert (recon.reconstruct(x, t) @ np.arange(len(x))).dtype == np.float64


def test_masked_points_are_left_out_and_keep_their_rows() -> None:
    x, t = jittered(14, 2), inner(30, 2)
    u = np.stack([linear(x), quadratic(x)], axis=1)
    hidden = np.zeros(len(x), dtype=bool)
    hidden[::5] = True
    points = masked(x, mask=np.stack([hidden, np.zeros_like(hidden)], axis=1))
    plain = recon.reconstruct(x[~hidden], t, radius=0.25)
    fit = recon.reconstruct(points, t, radius=0.25)
    assert fit.shape == (30, len(x)) and recon.Sources(points).size == np.sum(~hidden)
    u[hidden] = np.nan
    for field in (u, masked(u, mask=np.isnan(u))):
        np.testing.assert_array_equal(fit @ field, plain @ u[~hidden])
        np.testing.assert_array_equal(fit.gradient() @ field, plain.gradient() @ u[~hidden])
    back = fit.T @ t
    assert (back[hidden] == 0).all()
    np.testing.assert_array_equal(back[~hidden], plain.T @ t)
    np.testing.assert_array_equal(fit.gradient().T @ np.ones((30, 2)), fit.gradient().to_scipy().T @ np.ones(60))
    assert not hidden[fit.neighbours().indices].any() and not hidden[fit.row(3)[0]].any()
    axes = recon.Sources((masked(x[:, 0], mask=hidden), x[:, 1]))
    np.testing.assert_array_equal(recon.reconstruct(axes, t, radius=0.25) @ u, plain @ u[~hidden])
    weights = np.linspace(1, 2, len(x))
    np.testing.assert_array_equal(
        recon.reconstruct(points, t, radius=0.25, particle_weights=weights) @ u,
        recon.reconstruct(x[~hidden], t, radius=0.25, particle_weights=weights[~hidden]) @ u[~hidden],
    )
    u[1, 1] = np.nan
    with pytest.raises(recon.InvalidArgument, match="point 0 = nan: .*counted without the masked ones"):
        recon.reconstruct(points, x, radius=0.25) @ u
    u[~hidden] = 1
    wrong = masked(u, mask=False)
    wrong[1, 0] = np.ma.masked
    with pytest.raises(recon.InvalidArgument, match="field = masked in row 1: must have a value"):
        fit @ wrong
    with pytest.raises(recon.InvalidArgument, match="rows of the field = 156: must be one for each point"):
        fit @ u[~hidden]
    with pytest.raises(recon.InvalidArgument, match="targets = an array with masked entries"):
        recon.reconstruct(x, points)
    np.testing.assert_array_equal(
        recon.reconstruct(x, t) @ masked(x), recon.reconstruct(x, t) @ x
    )


def test_tables_of_pandas() -> None:
    pandas = pytest.importorskip("pandas")
    x, t = jittered(12, 2), inner(20, 2)
    table = pandas.DataFrame({"x": x[:, 0], "y": x[:, 1], "u": linear(x), "n": np.arange(len(x))})
    expected = recon.reconstruct(x, t) @ linear(x)
    np.testing.assert_array_equal(recon.reconstruct(table[["x", "y"]], t) @ table["u"], expected)
    np.testing.assert_array_equal(recon.reconstruct((table.x, table.y), t) @ table.u, expected)
    both = recon.reconstruct((table.x, table.y), t) @ table[["u", "n"]]
    np.testing.assert_array_equal(both[:, 0], expected)
    table.loc[3, "u"] = None
    with pytest.raises(recon.InvalidArgument, match="component 0 of the field at point 3 = nan"):
        recon.reconstruct((table.x, table.y), x) @ table.u
    table["name"] = "grain"
    with pytest.raises(recon.InvalidArgument, match="must be an array of real numbers"):
        recon.reconstruct(table[["x", "name"]], t)


def test_what_holds_no_numbers_is_refused() -> None:
    x = jittered(5, 2)
    wrong: list[tuple[Any, str]] = [
        (x + 1j, "an array of complex128: must be an array of real numbers"),
        (np.array(["a", "b"]), "must be an array of real numbers"),
        (np.array(["2020-01-01"], dtype="M8[D]"), "must be an array of real numbers"),
        (np.zeros((3, 4)), "columns of the points = 4: must be 1, 2 or 3"),
        (np.zeros((3, 0)), "columns of the points = 0"),
        (np.zeros((3, 2, 2)), "points = an array of shape \\(3, 2, 2\\)"),
        (np.float64(3), "points = an array of shape"),
        (None, "points = an array of shape"),
        ([None, "x"], "points = an array of object: must be an array of real numbers"),
        ([[1.0, 2.0], [1.0]], "points"),
        ((x[:, 0], x[:3, 1]), "length of a coordinate array = 3"),
    ]
    for points, text in wrong:
        with pytest.raises((recon.InvalidArgument, ValueError), match=text):
            recon.Sources(points)
    with pytest.raises(recon.InvalidArgument, match="coordinate y of point 2"):
        recon.Sources(np.where(np.arange(50).reshape(25, 2) == 5, np.nan, x))


def test_empty_clouds_and_targets() -> None:
    x = jittered(5, 2)
    fit = recon.reconstruct(x, np.zeros((0, 2)))
    assert (fit @ x).shape == (0, 2) and (fit.gradient() @ x).shape == (0, 2, 2)
    np.testing.assert_array_equal(fit.T @ np.zeros((0, 2)), np.zeros((25, 2)))
    nothing = recon.reconstruct(np.zeros((0, 2)), x)
    assert np.isnan(nothing @ np.zeros(0)).all()
    assert nothing.report.no_support() == 25
    assert fit.to_scipy().shape == (0, 25)


def test_short_forms_are_what_they_stand_for() -> None:
    x, t = jittered(12, 2), inner(20, 2)
    u = quadratic(x)
    pairs: list[tuple[dict[str, Any], dict[str, Any]]] = [
        ({"radius": 0.3}, {"neighbours": recon.Radius(0.3)}),
        ({"nearest": 9}, {"neighbours": recon.Nearest(9)}),
        ({"nearest": np.int64(9), "radius": 0.2}, {"neighbours": recon.NearestWithin(9, 0.2)}),
        ({"method": "mls"}, {"solver": "moment_matrix"}),
        ({"method": "imls"}, {"solver": recon.Solver.gram_schmidt}),
        ({"method": "shepard"}, {"degree": 0}),
        ({"weight": "cubic"}, {"weight": recon.Weight.cubic_b_spline}),
        ({"grow": 2}, {"grow": recon.Growth(2, 1.25)}),
    ]
    for short, long in pairs:
        np.testing.assert_array_equal(
            recon.reconstruct(x, t, **short) @ u, recon.reconstruct(x, t, **long) @ u
        )
    radii = np.full(20, 0.3)
    np.testing.assert_array_equal(
        recon.reconstruct(x, t, neighbours=recon.Radii(radii)) @ u,
        recon.reconstruct(x, t, radius=0.3) @ u,
    )
    fit = recon.reconstruct(x, t, neighbours=recon.PairRadii(np.full(len(x), 0.3)))
    np.testing.assert_allclose(fit @ u, recon.reconstruct(x, t, radius=0.3) @ u, rtol=1e-10)
    assert fit.neighbours().pair_support is not None


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"raduis": 1}, "option = 'raduis': is not known; did you mean 'radius'?"),
        ({"neighbors": 1}, "option = 'neighbors': is not known; did you mean 'neighbours'?"),
        ({"raduis": None}, "option = 'raduis': is not known; did you mean 'radius'?"),
        ({"weight": "cubic_spline"}, "weight = 'cubic_spline': is not known; did you mean 'cubic_b_spline'"),
        ({"solver": "gram"}, "solver = 'gram': is not known; did you mean 'gram_schmidt'?"),
        ({"method": "imsl"}, "method = 'imsl': is not known; did you mean 'imls'"),
        ({"method": "rbf"}, "method = 'rbf': is not known; valid: shepard, mls, imls"),
        ({"form": 3}, "form = 3: must be a text, the name of an enumerator"),
        ({"degree": "one"}, "degree = 'one': must be a number"),
        ({"degree": 1.5}, "degree = 1.5: must be a whole number"),
        ({"degree": 5}, "degree = 5: must be 0 to 4"),
        ({"degree": 1, "method": "shepard"}, "degree = 1: must be 0 for the method 'shepard'"),
        ({"method": "mls", "solver": "qr"}, "method = 'mls': stands for a solver: say one of both"),
        ({"radius": 1, "neighbours": recon.Nearest(4)}, "radius = given: stands for neighbours"),
        ({"radius": -1}, "radius = -1: must be positive and finite"),
        ({"radius": float("nan")}, "radius = nan: must be positive and finite"),
        ({"nearest": 2.5}, "nearest = 2.5: must be a whole number"),
        ({"nearest": -1}, "nearest = -1: must be a whole number, 0 or more"),
        ({"neighbours": 4}, "neighbours = 4: must be a Radius"),
        ({"stretch": [1, 2, 3, 4]}, "stretch = 4: must have 1, 2 or 3 numbers"),
        ({"domain": 1}, "domain = 1: must be a recon.PeriodicDomain"),
        ({"particle_weights": [1.0]}, "particle_weights"),
        ({"weight": object()}, "must be a name, or an object with"),
        ({"threads": -1}, "threads = -1: must not be negative"),
        ({"progress": 3}, "progress = 3: must be callable"),
        ({"visible": 3}, "visible = 3: must be callable"),
        ({"visible": lambda target, particle: None}, "answer of visible = None: must be True or False"),
        ({"neighbours": recon.Radii([0.1])}, "must"),
    ],
)
def test_slips_are_named(options: dict[str, Any], message: str) -> None:
    with pytest.raises(recon.InvalidArgument) as caught:
        recon.reconstruct(jittered(6, 2), inner(3, 2), **options)
    assert message in str(caught.value)
    assert isinstance(caught.value, ValueError)
    assert f"{caught.value.argument} = {caught.value.value}: {caught.value.rule}" == str(caught.value)


def test_what_belongs_to_sources_is_said_there() -> None:
    x, t = jittered(12, 2), inner(20, 2)
    domain = recon.PeriodicDomain((0, 0), (1, 1))
    weights = np.linspace(1, 2, len(x))
    sources = recon.Sources(x, domain=domain, particle_weights=weights, stretch=(1, 2))
    u = np.sin(2 * np.pi * x[:, 0])
    np.testing.assert_array_equal(
        recon.reconstruct(sources, t) @ u,
        recon.reconstruct(x, t, domain=domain, particle_weights=weights, stretch=(1, 2)) @ u,
    )
    with pytest.raises(recon.InvalidArgument, match="belongs to the Sources"):
        recon.reconstruct(sources, t, domain=domain)
    with pytest.raises(recon.InvalidArgument, match="option of Sources = 'domian'.*did you mean 'domain'"):
        recon.Sources(x, domian=domain)  # type: ignore[call-arg]
    assert sources.domain.periodic == (True, True) and len(sources) == len(x)
    assert sorted(sources.order) == list(range(len(x)))


def test_updates_follow_particles_and_refuse_what_is_stale() -> None:
    x, t = jittered(12, 2), inner(20, 2)
    sources = recon.Sources(x)
    fit = recon.reconstruct(sources, t, radius=0.3)
    gradient = fit.gradient()
    moved = x + 0.01 * np.sin(7 * x)
    sources.update(moved)
    calls: list[Callable[[], Any]] = [
        lambda: fit @ x,
        lambda: fit.T @ t,
        lambda: fit.report.degree,
        lambda: fit.gradient(),
        lambda: fit.neighbours(),
        lambda: fit.support(),
        lambda: gradient @ x,
        lambda: 2 * gradient,
        lambda: gradient.to_scipy(),
        lambda: gradient.row(0),
    ]
    for stale in calls:
        with pytest.raises(recon.InvalidArgument, match="before an update of the Sources"):
            stale()
    fit.update(t)
    np.testing.assert_array_equal(fit @ x, recon.reconstruct(moved, t, radius=0.3) @ x)
    fit.update(t[:5], radius=0.4)
    np.testing.assert_array_equal(fit @ x, recon.reconstruct(moved, t[:5], radius=0.4) @ x)
    sources.update(moved[:90])
    fit.update(t)
    assert fit.shape == (20, 90)
    with pytest.raises(recon.InvalidArgument, match="coordinate x of point 0"):
        sources.update(np.full((4, 2), np.nan))
    assert fit.shape == (20, 90) and np.isfinite(fit @ moved[:90]).all()


def test_operators_of_one_fit_add_up() -> None:
    x, t = jittered(14, 2), inner(20, 2)
    u = np.stack([quadratic(x), linear(x)], axis=1)
    fit = recon.reconstruct(x, t, degree=2)
    value, lap, first = fit.operators("value", "laplacian", recon.Functional.partial(1))
    dt: Any = np.float64(0.1)
    heat = value + dt * lap
    np.testing.assert_allclose(heat @ u, fit @ u + 0.1 * (lap @ u), rtol=1e-12)
    np.testing.assert_allclose((fit - lap / 2) @ u, fit @ u - 0.5 * (lap @ u), atol=1e-12)
    np.testing.assert_allclose((-first + first) @ u, 0, atol=1e-12)
    np.testing.assert_allclose(heat.T @ t, heat.to_scipy().T @ t, rtol=1e-9, atol=1e-12)
    with pytest.raises(recon.InvalidArgument):
        value + fit.gradient()
    with pytest.raises(recon.InvalidArgument):
        value + recon.reconstruct(x, t, degree=1).values
    with pytest.raises(TypeError):
        value + 3  # type: ignore[operator]
    with pytest.raises(recon.InvalidArgument, match="functional = 'laplace': is not known; did you mean 'laplacian'"):
        fit.operators("laplace")


def test_functionals_of_the_local_polynomial() -> None:
    x, t = jittered(14, 2), inner(20, 2)
    fit = recon.reconstruct(x, t, degree=2)
    F = recon.Functional
    square = x[:, 0] ** 2
    h = 0.1
    average, line, near, own, pair = fit.operators(
        F.cell_average((h, h)),
        F.line_integral((0, 0), (h, 0)),
        F.value.at([(h, 0.0), (0.0, h)]),
        F.own(lambda n: (1.0, 0.0, h * h / 12)[n[0]] if n[1] == 0 else 0.0),
        F.own(lambda target, n: [float(n == (0, 0, 0)), float(target) * (n == (0, 0, 0))], 2, True),
    )
    np.testing.assert_allclose(average @ square, t[:, 0] ** 2 + h * h / 12, rtol=1e-9)
    np.testing.assert_allclose(line @ square, ((t[:, 0] + h) ** 3 - t[:, 0] ** 3) / 3, rtol=1e-9)
    np.testing.assert_allclose(
        near @ square, np.stack([(t[:, 0] + h) ** 2, t[:, 0] ** 2], axis=1), rtol=1e-9
    )
    np.testing.assert_allclose(own @ square, t[:, 0] ** 2 + h * h / 12, rtol=1e-9)
    np.testing.assert_allclose((pair @ square)[:, 1], np.arange(20) * (fit @ square), rtol=1e-12)
    diffuse = fit.operators(F.gradient.with_slopes("diffuse"))[0]
    np.testing.assert_array_equal(diffuse @ square, fit.gradient("diffuse") @ square)
    with pytest.raises(ZeroDivisionError):
        fit.operators(F.own(lambda n: 1 / 0))


def test_matrices_of_scipy() -> None:
    x, t = jittered(20, 2), inner(300, 2)
    fit = recon.reconstruct(x, t, radius=0.15)
    u = np.random.default_rng(7).normal(size=len(x))
    matrix = fit.to_scipy()
    assert isinstance(matrix, scipy.sparse.csr_matrix) and matrix.indices.dtype == np.int32
    np.testing.assert_allclose(matrix @ u, fit @ u, rtol=1e-12)
    np.testing.assert_allclose(matrix.sum(axis=1), 1, rtol=1e-12)
    gradient = fit.gradient()
    np.testing.assert_allclose(
        (gradient.to_scipy() @ u).reshape(300, 2), gradient @ u, rtol=1e-9, atol=1e-9
    )
    particles, phi = fit.row(17)
    assert phi @ u[particles] == pytest.approx((fit @ u)[17])
    assert gradient.row(17)[1].shape == (len(particles), 2)
    # Iterative solvers take operators as they are.
    solved = scipy.sparse.linalg.lsqr(fit, fit @ u, iter_lim=40)[0]
    np.testing.assert_allclose(
        solved, scipy.sparse.linalg.lsqr(matrix, fit @ u, iter_lim=40)[0], atol=1e-9
    )
    linear_operator = scipy.sparse.linalg.aslinearoperator(gradient)
    np.testing.assert_array_equal(linear_operator.matvec(u), (gradient @ u).ravel())
    np.testing.assert_array_equal(linear_operator.rmatvec(np.ones(600)), gradient.T @ np.ones((300, 2)))


def test_matrices_of_what_mixes_components() -> None:
    x, t = jittered(10, 3), inner(40, 3)
    fit = recon.reconstruct(x, t)
    v = np.random.default_rng(12).normal(size=x.shape)
    for op in (fit.divergence(), fit.curl(), fit.strain_rate()):
        matrix = op.to_scipy()
        assert matrix.shape == op.shape and op.shape[1] == 3 * len(x)
        np.testing.assert_allclose(matrix @ v.ravel(), (op @ v).ravel(), atol=1e-9)
        np.testing.assert_allclose(op.matvec(v.ravel()), (op @ v).ravel(), atol=0)
        f = np.random.default_rng(13).normal(size=op.shape[0])
        np.testing.assert_allclose(op.T.to_scipy() @ f, op.rmatvec(f), atol=1e-9)
        hidden = recon.reconstruct(masked(x, mask=x < 0.02), t)
        assert hidden.divergence().to_scipy().shape == (40, 3 * len(x))


def test_lists_of_neighbours_of_ones_own_with_int64() -> None:
    x, t = jittered(10, 2), inner(15, 2)
    sources = recon.Sources(x)
    found = recon.find_neighbours(sources, t, radius=0.3)
    assert len(found) == 15 and found.indices.dtype == np.int64
    own = recon.NeighbourList(found.offsets, found.indices.astype(np.int64), np.full(15, 0.3))
    np.testing.assert_allclose(
        recon.reconstruct(x, t, neighbours=own) @ x, recon.reconstruct(x, t, radius=0.3) @ x, rtol=1e-12
    )
    nobody = recon.NeighbourList([0, 0], [], [1.0])
    assert recon.reconstruct(x, t[:1], neighbours=nobody).report.no_support() == 1
    with pytest.raises(recon.InvalidArgument, match=r"indices\[1\] = -1"):
        recon.NeighbourList([0, 2], [0, -1], [1.0])
    with pytest.raises(recon.InvalidArgument, match="must be a one-dimensional array of integers"):
        recon.NeighbourList([0, 2], [0.0, 1.0], [1.0])
    with pytest.raises(recon.InvalidArgument):
        recon.reconstruct(x, t, neighbours=recon.NeighbourList([0, 1], [100], [1.0]))
    periodic = recon.Sources(x, domain=recon.PeriodicDomain((0, 0), (1, 1)))
    images = recon.find_neighbours(periodic, [[0.0, 0.0]], nearest=8)
    assert images.shifts is not None and images.shifts.shape == (8, 3)


def test_weights_of_ones_own() -> None:
    class Parabola:
        def __call__(self, q: float) -> float:
            return (1 - q * q) ** 2

        def derivative(self, q: float) -> float:
            return -4 * q * (1 - q * q)

    class Negative(Parabola):
        def __call__(self, q: float) -> float:
            return -1.0

    x, t = jittered(12, 2), inner(20, 2)
    fit = recon.reconstruct(x, t, weight=Parabola(), radius=0.3)
    np.testing.assert_allclose(fit @ linear(x), linear(t), rtol=1e-11)
    with pytest.raises(recon.InvalidArgument, match=r"weight w\(q\) at q = .*must be finite and not negative"):
        recon.reconstruct(x, t, weight=Negative(), radius=0.3)
    wide, narrow = (recon.reconstruct(x, t, weight=recon.Gaussian(c)) for c in (2.0, 0.2))
    assert np.abs(wide @ quadratic(x) - narrow @ quadratic(x)).max() > 1e-6
    with pytest.raises(recon.InvalidArgument, match="softening of the weight InverseDistance = 0"):
        recon.InverseDistance(0)


def test_reports_are_arrays() -> None:
    x = np.concatenate([jittered(12, 2), [[3.0, 3.0], [3.1, 3.0]]])
    t = np.array([[0.5, 0.5], [3.0, 3.05], [9.0, 9.0]])
    fit = recon.reconstruct(x, t, radius=0.3)
    report = fit.report
    assert list(report.degree) == [1, 0, -1] and list(report["degree"]) == [1, 0, -1]
    assert [recon.FitStatus(s).name for s in report.status] == ["full", "reduced", "no_support"]
    assert report.kept.shape == (3, 9) and set(report) == set(report.keys())
    assert list(report.with_status("reduced")) == [1]
    assert list(report.with_status(recon.FitStatus.no_support)) == [2]
    assert report.reduced() == 1 and report.no_support() == 1 and report.totals()["targets"] == 3
    assert "3 targets: 1 full, 1 reduced, 1 without support" in report.summary()
    assert {name: array.shape[0] for name, array in report.items()} == dict.fromkeys(report, 3)
    assert list(fit.values.empty_rows) == [2] and np.isnan((fit @ x)[2]).all()
    with pytest.raises(recon.InvalidArgument, match="'degre': is not known; did you mean 'degree'"):
        report["degre"]


def test_values_are_kept_in_the_range_of_their_data() -> None:
    x, t = jittered(14, 2), inner(100, 2)
    step = (x[:, 0] > 0.5).astype(float)
    fit = recon.reconstruct(x, t, degree=2)
    free = fit @ step
    held, count = fit.apply(step, limit="range", return_count=True)
    assert free.max() > 1 and held.max() <= 1 and held.min() >= 0
    assert count.shape == (100,) and count.sum() == np.sum((free > 1 + 1e-9) | (free < -1e-9))
    with pytest.raises(recon.InvalidArgument, match="limit = 'rang': is not known; did you mean 'range'"):
        fit.apply(step, limit="rang")


def test_results_go_into_an_array_of_the_callers() -> None:
    x, t = jittered(10, 2), inner(20, 2)
    fit = recon.reconstruct(x, t)
    wide = np.full((20, 5), -1.0)
    assert fit.apply(x, out=wide[:, 1:4:2]) is not None
    np.testing.assert_array_equal(wide[:, 1:4:2], fit @ x)
    assert (wide[:, ::2] == -1).all()
    gradient = np.empty((20, 2, 2))
    fit.gradient().apply(x, gradient)
    np.testing.assert_array_equal(gradient, fit.gradient() @ x)
    for out, text in [
        (np.empty((20, 3)), "must have the shape of the result"),
        (np.empty((20, 2), dtype="f4"), "must be an array of float64"),
        (np.broadcast_to(np.empty((20, 1)), (20, 2)), "must be writeable"),
    ]:
        with pytest.raises(recon.InvalidArgument, match=text):
            fit.apply(x, out=out)
    square = recon.reconstruct(x, x)
    with pytest.raises(recon.InvalidArgument, match="must not overlap the field"):
        square.apply(x, out=x)


def test_data_that_are_not_finite_are_named_where_they_are_needed() -> None:
    x = jittered(10, 2)
    fit = recon.reconstruct(x, inner(20, 2), radius=0.15)
    u = np.ones((100, 2))
    u[np.abs(x - 0.5).max(axis=1) > 0.48] = np.nan  # beyond every support
    assert np.isfinite(fit @ u).all()
    u[55, 1] = np.inf
    with pytest.raises(recon.InvalidArgument, match="component 1 of the field at point 55 = inf: must be finite"):
        fit @ u
    assert np.isinf(fit.apply(u, trusted=True)).any() or np.isnan(fit.apply(u, trusted=True)).any()


def test_hidden_particles_take_no_part() -> None:
    x, t = jittered(10, 2), inner(10, 2)
    left = x[:, 0] < 0.5
    fit = recon.reconstruct(
        x, t, visible=lambda target, particle: bool(left[particle] == (t[target, 0] < 0.5)), radius=0.3
    )
    u = left.astype(float)
    np.testing.assert_allclose(fit @ u, t[:, 0] < 0.5, atol=1e-12)

    def broken(target: int, particle: int) -> bool:
        raise KeyError("no such wall")

    with pytest.raises(KeyError, match="no such wall"):
        recon.reconstruct(x, t, visible=broken, radius=0.3)


def test_sums_over_kernels() -> None:
    side = 40
    x = (np.stack(np.meshgrid(np.arange(side), np.arange(side)), -1).reshape(-1, 2) + 0.5) / side
    sources = recon.Sources(x, domain=recon.PeriodicDomain((0, 0), (1, 1)))
    mass = np.full(len(x), 2.0 / len(x))
    density = recon.kernel_sum(sources, inner(30, 2), mass, weight="wendland_c4", radius=0.2)
    np.testing.assert_allclose(density, 2, rtol=1e-3)
    op = recon.kernel_operator(sources, inner(30, 2), weight="wendland_c4", radius=0.2)
    np.testing.assert_array_equal(op @ mass, density)
    grid = recon.StructuredGrid((0, 0), 0.25, (5, 5))
    assert recon.kernel_sum(sources, grid, mass, nearest=20).shape == (25,)


def test_objects_keep_what_they_need() -> None:
    x, t = jittered(10, 2), inner(20, 2)
    expected = recon.reconstruct(x, t) @ x
    gradient = recon.reconstruct(recon.Sources(x.copy()), t.copy()).gradient()
    transposed = recon.reconstruct(x.copy(), t.copy()).T
    report = recon.reconstruct(x.copy(), t.copy()).report
    assert (gradient @ x).shape == (20, 2, 2) and (report.degree == 1).all()
    np.testing.assert_array_equal(transposed.T @ x, expected)


def test_grids_as_targets() -> None:
    x = jittered(14, 2)
    grid = recon.StructuredGrid((0.2, 0.3), (0.1, 0.05), (5, 7))
    fit = recon.reconstruct(x, grid, radius=0.3)
    assert fit.grid == grid and grid.shape == (5, 7) and grid.size == 35
    values = grid.reshape(fit @ linear(x))
    X, Y = np.meshgrid(*grid.axes, indexing="ij")
    np.testing.assert_allclose(values, 1 + 2 * X - 3 * Y, atol=1e-12)
    assert grid.reshape(fit.gradient() @ x).shape == (5, 7, 2, 2)
    np.testing.assert_array_equal(grid.reshape(grid.nodes())[3, 4], [grid.axes[0][3], grid.axes[1][4]])
    fit.update(x[:4])
    assert fit.grid is None
    with pytest.raises(recon.InvalidArgument, match="must have a row for each of the 35 nodes"):
        grid.reshape(np.zeros(34))
    assert recon.covering_grid(x, 0.25) == recon.StructuredGrid((0, 0), 0.25, (5, 5))
    assert recon.cell_centres(grid).shape == (4, 6)


@pytest.mark.parametrize("kind", ["f4", "f8"])
def test_values_on_grids(kind: str) -> None:
    x = jittered(16, 3).astype(kind)
    u, v = linear(x), np.stack([x[:, 0], x[:, 1] ** 2], axis=1)
    grid = recon.StructuredGrid((0.25, 0.25, 0.25), 0.125, (5, 4, 3))
    result = recon.on_grid(x, {"u": u, "v": v}, grid, radius=0.25, gradients="diffuse")
    assert result["u"].shape == (5, 4, 3) and result["v"].shape == (5, 4, 3, 2)
    X = np.stack(np.meshgrid(*grid.axes, indexing="ij"), axis=-1)
    np.testing.assert_allclose(result["u"], linear(X.reshape(-1, 3)).reshape(5, 4, 3), rtol=1e-4)
    assert result.gradients["u"].shape == (5, 4, 3, 3) and result.gradients["v"].shape == (5, 4, 3, 2, 3)
    np.testing.assert_allclose(result.gradients["u"] - [2, -3, 4], 0, atol=2e-4)
    np.testing.assert_allclose(result.gradients["v"][..., 0, :] - [1, 0, 0], 0, atol=2e-4)
    fit = recon.reconstruct(x, grid, radius=0.25)
    np.testing.assert_allclose(grid.reshape(fit @ v), result["v"], rtol=1e-4)
    alone = recon.on_grid(recon.Sources(x), v, grid, radius=0.25, limit="range")
    assert alone.values.shape == (5, 4, 3, 2) and alone.limited.shape == (5, 4, 3)
    assert alone.values.dtype == np.dtype(kind)
    as_dict = result.to_dict()
    assert as_dict["data_vars"]["v"]["dims"] == ("x", "y", "z", "v_0")
    assert as_dict["data_vars"]["gradient_of_v"]["dims"] == ("x", "y", "z", "v_0", "axis")
    assert grid.reshape(result.report.degree).shape == (5, 4, 3)
    whole = recon.on_grid(x, u, 0.25)
    assert whole.values.shape == whole.grid.shape == (5, 5, 5)
    with pytest.raises(KeyError, match="there are u, v"):
        result["w"]
    with pytest.raises(recon.InvalidArgument, match="option = 'degre'"):
        recon.on_grid(x, u, grid, degre=2)
    with pytest.raises(recon.InvalidArgument, match="fields = {}: must be at least one"):
        recon.on_grid(x, {}, grid)
