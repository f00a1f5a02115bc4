"""Contenders of bench_transfer_fit.py that need more than a few lines, used as their manuals say.

Each takes input and output (N,) and the period (s), and gives theta = (beta_1, beta_0, alpha_1, alpha_0) with standard errors or None.
"""

import contextlib
import importlib
import io

import numpy as np

SCENE = """<mujoco><option timestep="{step}" gravity="0 0 0" integrator="RK4"/><worldbody><body><joint name="j" type="slide" damping="5"
stiffness="30"/><geom size="0.1" mass="1"/></body></worldbody><actuator><motor name="u" joint="j"/></actuator>
<sensor><jointpos name="x" joint="j"/></sensor></mujoco>"""
PER_SAMPLE = 4  # steps of MuJoCo, which holds the input during each: it is given as it is halfway
MOST = 1000.0


def mujoco_sysid(u: np.ndarray, y: np.ndarray, dt: float):
    """A unit mass on a spring and a dashpot, driven by the input; the output is beta_1 times its speed plus beta_0 times its position."""
    mujoco, sysid = importlib.import_module("mujoco"), importlib.import_module("mujoco.sysid")
    if not hasattr(sysid, "optimize"):
        raise ImportError("mujoco[sysid]")
    spec = mujoco.MjSpec.from_string(SCENE.format(step=dt / PER_SAMPLE))
    model, t = spec.compile(), np.arange(u.size) * dt
    sequences = sysid.ModelSequences(
        "skin",
        spec,
        "bench",
        sysid.create_initial_state(model, np.zeros(1)),
        sysid.TimeSeries.from_control_names(t, (np.interp(t + 0.5 * dt / PER_SAMPLE, t, u) - u[0])[:, None], model),
        sysid.TimeSeries.from_names(t, y[:, None], model),
    )
    parameters = sysid.ParameterDict()
    for name, start in (("beta1", 3.0), ("beta0", 20.0)):
        parameters.add(sysid.Parameter(name, start, -MOST, MOST))
    parameters.add(sysid.Parameter("damping", 5.0, 0.1, MOST, modifier=_joint("damping")))
    parameters.add(sysid.Parameter("stiffness", 30.0, 0.1, MOST, modifier=_joint("stiffness")))

    def compared(p, predicted, measured, model, return_all, state, sensor_weights=None):
        v = {name: float(p[name].value[0]) for name in ("beta1", "beta0", "stiffness")}
        x, speed = (np.interp(t, np.concatenate([[0.0], state[:, 0]]), np.concatenate([[0.0], column])) for column in state.T[1:3])
        return v["beta1"] * speed + v["beta0"] * (x + u[0] / v["stiffness"]) - y, measured, measured

    residual = sysid.build_residual_fn(models_sequences=[sequences], modify_residual=compared, n_threads=1)
    with contextlib.redirect_stdout(io.StringIO()):
        found, result = sysid.optimize(parameters, residual, optimizer="mujoco", verbose=False, max_iters=60, x_scale="jac")
    left, *_ = residual(result.x, found)
    covariance, _ = sysid.calculate_intervals(left, result.jac)
    return found.as_vector(), np.sqrt(np.diag(covariance))


def _joint(name: str):
    def modifier(spec, parameter) -> None:
        setattr(spec.joint("j"), name, _like(getattr(spec.joint("j"), name), float(parameter.value[0])))

    return modifier


def _like(old, value: float):
    """MuJoCo keeps some of a joint's numbers as arrays of polynomial coefficients."""
    if np.ndim(old) == 0:
        return value
    new = np.zeros_like(old)
    new.flat[0] = value
    return new


def sippy_arx(u: np.ndarray, y: np.ndarray, dt: float):
    """SIPPY's ARX by least squares."""
    return _sippy(u - u[0], y - y[0], dt, "ARX", ARX_orders=[2, 3, 0])


def sippy_output_error(u: np.ndarray, y: np.ndarray, dt: float):
    """SIPPY's output error, by a general optimiser."""
    return _sippy(u, y, dt, "OE", centering="MeanVal", OE_orders=[3, 2, 0])


def _sippy(u: np.ndarray, y: np.ndarray, dt: float, method: str, **how):
    sippy = importlib.import_module("sippy_unipi")
    with contextlib.redirect_stdout(io.StringIO()):
        model = sippy.system_identification(y, u, method, tsample=dt, **how)
    num, den = np.ravel(model.NUMERATOR), np.ravel(model.DENOMINATOR)
    return _from_discrete(den[:3], num.sum() / den.sum(), dt)


def sysidentpy_narx(u: np.ndarray, y: np.ndarray, dt: float, extended: bool = False):
    """SysIdentPy, linear polynomial terms chosen by FROLS, by least squares or by its extended least squares."""
    frols = importlib.import_module("sysidentpy.model_structure_selection").FROLS
    polynomial = importlib.import_module("sysidentpy.basis_function").Polynomial
    estimator = importlib.import_module("sysidentpy.parameter_estimation").LeastSquares(unbiased=extended)
    model = frols(n_terms=5, order_selection=False, ylag=2, xlag=2, estimator=estimator, basis_function=polynomial(degree=1))
    model.fit(X=(u - u[0])[:, None], y=(y - y[0])[:, None])
    theta = dict(zip([tuple(row) for row in model.final_model], model.theta.ravel(), strict=True))
    den = np.array([1.0, -theta.get((1001,), 0.0), -theta.get((1002,), 0.0)])
    return _from_discrete(den, (theta.get((2001,), 0.0) + theta.get((2002,), 0.0)) / den.sum(), dt)


def _from_discrete(den: np.ndarray, gain: float, dt: float):
    """Continuous poles and the static gain; beta_1 is not asked for."""
    poles = np.log(np.roots(den).astype(complex)) / dt
    return np.array([np.nan, gain * poles.prod().real, -poles.sum().real, poles.prod().real]), None


def pysindy_linear(u: np.ndarray, y: np.ndarray, dt: float):
    """Sparse regression of the second derivative on y, y', u and u', with the library's smoothed differences as they come.

    Their window of 11 samples suits these data best: 5 leave 2.6 % of error under white noise, 17 1.5 %, 51 59 %.
    """
    ps = importlib.import_module("pysindy")
    smooth = ps.SmoothedFiniteDifference()
    rate_y, rate_u = smooth._differentiate(y[:, None], dt), smooth._differentiate(u[:, None], dt)
    states, inputs = np.column_stack([y, rate_y]), np.column_stack([u, rate_u])
    model = ps.SINDy(
        optimizer=ps.STLSQ(threshold=0.0),
        feature_library=ps.PolynomialLibrary(degree=1, include_bias=False),
        differentiation_method=smooth,
    )
    model.fit(states, t=dt, u=inputs)
    of_y, of_rate, of_u, of_rate_u = model.coefficients()[1]
    return np.array([of_rate_u, of_u, -of_rate, -of_y]), None
