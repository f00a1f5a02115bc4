"""Force is conserved: what is pressed comes out over the taxels plus the dispersed part, whatever the kernel, layout and contacts."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import dblquad, trapezoid

from skin_models.errors import ModelError
from skin_models.layout import A201_AREA, arbitrary, grid, hexagonal, row
from skin_models.spread.contacts import ContactError, Contacts, disc_points, sphere_patch
from skin_models.spread.field import SpreadField
from skin_models.spread.finite import Finite, disc_average
from skin_models.spread.kernels import Anisotropic, DepthWidth, Gaussian, GeneralisedGaussian, HeavyTail

C = 5.25e-3
KERNELS = [
    Gaussian(width=C),
    GeneralisedGaussian(width=C, power=4.0),
    HeavyTail(width=C, power=2.5),
    DepthWidth(Gaussian(width=C), growth=100.0),
    Anisotropic(Gaussian(width=C), ratio=1.5, angle=0.6),
    Anisotropic(DepthWidth(Gaussian(width=C), growth=50.0), ratio=0.7),
    Finite(Gaussian(width=2e-3), taxel_radius=2.5e-3, patch_radius=4.95e-3),
]
names = [type(k).__name__ for k in KERNELS]


def sphere_patch_layout(n=300, radius=60e-3):
    """Points spread evenly over a ball: curved skin with every normal."""
    i = np.arange(n) + 0.5
    z, angle = 1 - 2 * i / n, np.pi * (1 + 5**0.5) * i
    normals = np.column_stack([np.sqrt(1 - z**2) * np.cos(angle), np.sqrt(1 - z**2) * np.sin(angle), z])
    return arbitrary(radius * normals, normals)


LAYOUTS = [grid(16, 16, 3e-3), hexagonal(9, 9, 6e-3), row(3, 14e-3), grid(1, 1, 9e-3), sphere_patch_layout()]

a_contact = st.tuples(
    st.tuples(*[st.floats(-0.08, 0.08)] * 3),
    st.floats(0.0, 100.0),
    st.one_of(st.just(0.0), st.floats(0.0, 15e-3)),
    st.floats(0.0, 5e-3),
)


@pytest.mark.parametrize("kernel", KERNELS, ids=names)
@settings(max_examples=60, deadline=None)
@given(layout=st.sampled_from(LAYOUTS), some=st.lists(a_contact, max_size=6), peak=st.one_of(st.none(), st.floats(0.0, 1.0)))
def test_force_is_conserved(kernel, layout, some, peak):
    contacts = Contacts([c[0] for c in some], [c[1] for c in some], [c[2] for c in some], [c[3] for c in some])
    out = SpreadField(layout, kernel, peak, reference_area=A201_AREA).spread(contacts)
    total = contacts.force.sum()
    assert out.taxels.sum() + out.dispersed == pytest.approx(total, rel=1e-9, abs=1e-300)
    assert np.all(out.taxels >= 0.0) and -1e-9 * total <= out.dispersed <= total * (1 + 1e-9)


@pytest.mark.parametrize("kernel", KERNELS, ids=names)
def test_area_is_the_integral_of_the_shape(kernel):
    r = kernel.reach(1e-11) * np.linspace(0, 1, 400001) ** 2
    value = trapezoid(2 * np.pi * r * kernel.shape(r), r)
    rest = 2e-4 if isinstance(kernel, (Finite, HeavyTail)) else 1e-7
    assert value == pytest.approx(kernel.area, rel=rest)


@pytest.mark.parametrize("kernel", KERNELS, ids=names)
@pytest.mark.parametrize("tolerance", [1e-2, 1e-4, 1e-6])
def test_reach_keeps_what_it_promises(kernel, tolerance):
    if isinstance(kernel, Anisotropic):
        edge = np.linspace(0, 2 * np.pi, 100)
        r = kernel.distance(kernel.reach(tolerance) * np.cos(edge), kernel.reach(tolerance) * np.sin(edge))
    else:
        r = kernel.reach(tolerance) * np.linspace(1.0 + 1e-9, 3, 100)
    assert np.all(kernel.shape(r) <= tolerance * (1.0 + 1e-6))


def test_a_dense_field_passes_everything_inside_and_half_at_its_edge():
    """Nothing is left over in the middle, where the sum over taxels is the integral; at the edge the missing half is dispersed."""
    field = SpreadField(grid(80, 80, 1.5e-3), Gaussian(width=C), tolerance=1e-12)
    middle, edge = (field.spread(Contacts([[x, 0.0, 0.0]], [10.0])) for x in (0.4e-3, 40 * 1.5e-3))
    assert middle.taxels.sum() == pytest.approx(10.0, rel=1e-9)
    assert edge.taxels.sum() == pytest.approx(5.0, rel=1e-9) and edge.dispersed == pytest.approx(5.0, rel=1e-9)


def test_dispersed_at_a_corner_is_what_the_missing_taxels_would_have_got():
    full, part = grid(61, 61, 2e-3), grid(31, 31, 2e-3)
    corner = full.positions[30 * 61 + 30]  # centre of the full grid; put the part's corner there
    shifted = arbitrary(part.positions - part.positions[-1] + corner, part.normals, part.area)
    contact = Contacts([corner + np.array([0.7e-3, -1.1e-3, 0])], [3.0])
    whole = SpreadField(full, Gaussian(width=C), tolerance=1e-12).spread(contact).taxels.reshape(61, 61)
    out = SpreadField(shifted, Gaussian(width=C), tolerance=1e-12).spread(contact)
    assert out.taxels.sum() == pytest.approx(whole[:31, :31].sum(), rel=1e-12)
    assert out.dispersed == pytest.approx(3.0 - whole[:31, :31].sum(), rel=1e-9)


def test_measured_width_and_stiffness_of_the_thesis_leave_six_per_cent_for_no_taxel():
    """k1 / (k1 + k2) of 4 mm silicone under the taxel and c = 5.25 mm beside it: 94 % of the force would pass a closed layer of taxels."""
    share = 9619 / (9619 + 2766)
    assert share * Gaussian(width=C).area / A201_AREA == pytest.approx(0.943, abs=0.001)


def test_the_cut_off_is_chosen_by_the_stated_error():
    """100 contacts over 64 taxels: no taxel lacks more than the tolerance times the force pressed."""
    layout, rng = grid(8, 8, 5e-3), np.random.default_rng(0)
    contacts = Contacts(np.column_stack([rng.uniform(-20e-3, 20e-3, (100, 2)), np.zeros(100)]), rng.uniform(0, 5, 100))
    exact = SpreadField(layout, Gaussian(width=C), tolerance=1e-15).spread(contacts)
    for tolerance in (1e-3, 1e-5):
        cut = SpreadField(layout, Gaussian(width=C), tolerance=tolerance).spread(contacts)
        lost = exact.taxels - cut.taxels
        assert np.all(lost >= -1e-9) and lost.max() <= tolerance * contacts.force.sum()
        assert cut.taxels.sum() + cut.dispersed == pytest.approx(contacts.force.sum(), rel=1e-9)


def test_overlapping_contacts_add_up():
    field, at = SpreadField(grid(9, 9, 4e-3), Gaussian(width=C)), [[1e-3, 2e-3, 0], [-3e-3, 0, 0]]
    both = field.spread(Contacts(at, [1.0, 2.0])).taxels
    assert both == pytest.approx(sum(field.spread(Contacts([p], [f])).taxels for p, f in zip(at, (1.0, 2.0), strict=True)))


def test_curved_skin_does_not_feel_through_the_limb():
    layout = sphere_patch_layout(n=2000, radius=8e-3)
    out = SpreadField(layout, Gaussian(width=C)).spread(Contacts([[0, 0, 8e-3]], [1.0]))
    assert np.all(out.taxels[layout.normals[:, 2] < -0.1] == 0.0) and out.taxels.max() > 0


def test_a_contact_far_outside_reaches_nothing_and_is_counted():
    out = SpreadField(grid(4, 4, 5e-3), Gaussian(width=C)).spread(Contacts([[1.0, 0, 0], [0, 0, 0]], [2.0, 1.0]))
    assert out.outside == 1 and out.dispersed > 2.0


@pytest.mark.parametrize("kernel", KERNELS[:3] + KERNELS[4:5], ids=names[:3] + names[4:5])
def test_a_disc_is_the_average_over_its_area(kernel):
    field, a, at = SpreadField(row(1, 1.0), kernel, peak=1.0), 4e-3, np.array([6e-3, 1e-3, 0])
    got = field.spread(Contacts([at], [1.0], radius=a)).taxels[0]

    def under(p, t):
        one = Contacts([at + np.array([p * np.cos(t), p * np.sin(t), 0])], [1.0])
        return p * field.spread(one).taxels[0]

    x, w = np.polynomial.legendre.leggauss(24)
    t = np.pi * (x + 1)
    rings = [np.pi * w @ [under(a / 2 * (y + 1), angle) for angle in t] for y in x]
    assert got == pytest.approx(a / 2 * (w @ rings) / (np.pi * a**2), rel=0.01)


def test_disc_points_have_the_moments_of_an_even_disc():
    p, w = disc_points()
    r2 = (p**2).sum(axis=1)
    assert [w.sum(), w @ p[:, 0], w @ r2, w @ r2**2, w @ p[:, 0] ** 4] == pytest.approx([1, 0, 1 / 2, 1 / 3, 1 / 8], abs=1e-12)


def test_disc_average_agrees_with_two_dimensional_quadrature():
    g, a, r = Gaussian(width=2e-3), 4.95e-3, 3.3e-3
    f = lambda t, p: p * g.shape(np.hypot(r + p * np.cos(t), p * np.sin(t)))  # noqa: E731
    assert disc_average(g.shape, a, np.array([r]))[0] == pytest.approx(dblquad(f, 0, a, 0, 2 * np.pi)[0] / (np.pi * a**2), rel=1e-6)


def test_depth_widens_and_keeps_the_force():
    field = SpreadField(grid(60, 60, 1.5e-3), DepthWidth(Gaussian(width=C), growth=200.0), tolerance=1e-12)
    shallow, deep = (field.spread(Contacts([[0, 0, 0]], [1.0], depth=d)) for d in (0.0, 2e-3))
    assert deep.taxels.max() < shallow.taxels.max() / 1.8 and deep.taxels.sum() == pytest.approx(1.0, rel=1e-6)


def test_sphere_patch_grows_with_the_root_of_depth():
    assert sphere_patch(10e-3, 1e-3) == pytest.approx(np.sqrt(0.8 * 10e-6)) and sphere_patch(10e-3, -1.0) == 0.0


@pytest.mark.parametrize("bad", [dict(force=[-1.0]), dict(force=[np.nan]), dict(force=[1.0], radius=[-1e-3]), dict(force=[1.0, 2.0])])
def test_impossible_contacts_are_refused(bad):
    with pytest.raises(ContactError):
        Contacts([[0, 0, 0]], **bad)
    with pytest.raises(ContactError, match="finite position"):
        Contacts([[0, np.nan, 0]], [1.0])


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        ({"position": [[0.0, 0.0]]}, "x, y, z"),
        ({"depth": [np.inf]}, "finite depth"),
        ({"normal": [[0.0, 0.0, 0.0]]}, "direction"),
        ({"normal": [[0.0, np.nan, 1.0]]}, "direction"),
        ({"normal": [0.0, 1.0]}, "as many normals"),
    ],
)
def test_contacts_without_place_depth_or_direction_are_refused(wrong, says):
    with pytest.raises(ContactError, match=says):
        Contacts(**{"position": [[0.0, 0.0, 0.0]], "force": [1.0], **wrong})


def test_only_the_direction_of_a_normal_counts():
    field = SpreadField(grid(5, 5, 5e-3), Gaussian(width=C))
    one, three = (field.spread(Contacts([[0, 0, 0]], [1.0], normal=[[0, 0, n]])).taxels for n in (1.0, 3.0))
    assert np.array_equal(one, three)


def test_a_kernel_without_a_width_cannot_grow_with_depth():
    with pytest.raises(ModelError, match="put it around DepthWidth"):
        DepthWidth(Anisotropic(Gaussian(width=C), ratio=1.5), growth=100.0)


@pytest.mark.parametrize("bad", [dict(peak=1.2), dict(peak=-0.1), dict(tolerance=0.0), dict(reference_area=-1e-6)])
def test_impossible_fields_are_refused(bad):
    with pytest.raises(ModelError):
        SpreadField(grid(2, 2, 5e-3), Gaussian(width=C), **bad)
    with pytest.raises(ModelError, match="width"):
        Gaussian(width=-1.0)
