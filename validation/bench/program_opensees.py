"""OpenSees, through OpenSeesPy: corotational Euler-Bernoulli beams.

elasticBeamColumn with the Corotational transformation. Its thermal load is for the plane alone, so an element that
contracts is a dispBeamColumn on a section of uniaxial materials, the axial one in an InitStrainMaterial whose strain
is a parameter. Band LU for chains, sparse Cholesky for the tower, the fastest of its solvers on these; plain Newton.
"""

import time

import numpy as np

THEORY = "rigid"
PACKAGE = "openseespy"


def solve(frame, steps, tolerance=1e-8, iterations=60):
    import openseespy.opensees as ops

    ops.wipe()
    ops.model("basic", "-ndm", 3, "-ndf", 6)
    for k, x in enumerate(frame.X):
        ops.node(k + 1, *map(float, x))
    for k in frame.clamped:
        ops.fix(k + 1, 1, 1, 1, 1, 1, 1)
    tangents = frame.X[frame.conn[:, 1]] - frame.X[frame.conn[:, 0]]
    tangents /= np.linalg.norm(tangents, axis=1)[:, None]
    across = np.cross(tangents, frame.up)
    transformations, sections = {}, {}
    for e, (i, j) in enumerate(frame.conn):
        key = tuple(np.round(across[e], 9))
        if key not in transformations:
            transformations[key] = len(transformations) + 1
            ops.geomTransf("Corotational", transformations[key], *map(float, across[e]))
        s = frame.sec[frame.sec_of[e]]
        ends, transformation = (int(i) + 1, int(j) + 1), transformations[key]
        if frame.eps0[e] == 0:
            ops.element("elasticBeamColumn", e + 1, *ends, s.A, s.E, s.G, s.J, s.I, s.I, transformation)
            continue
        kind = (int(frame.sec_of[e]), float(frame.eps0[e]))
        if kind not in sections:
            tag = sections[kind] = 10 * (len(sections) + 1)
            ops.uniaxialMaterial("Elastic", tag, s.E * s.A)
            ops.uniaxialMaterial("InitStrainMaterial", tag + 1, tag, 0.0)
            ops.uniaxialMaterial("Elastic", tag + 2, s.E * s.I)
            ops.uniaxialMaterial("Elastic", tag + 3, s.E * s.I)
            ops.uniaxialMaterial("Elastic", tag + 4, s.G * s.J)
            ops.section("Aggregator", tag, tag + 1, "P", tag + 2, "Mz", tag + 3, "My", tag + 4, "T")
            ops.beamIntegration("Legendre", tag, tag, 2)
        ops.element("dispBeamColumn", e + 1, *ends, transformation, sections[kind])
    of_kind = {kind: [e + 1 for e, own in enumerate(kinds_of(frame)) if own == kind] for kind in sections}
    ops.timeSeries("Linear", 1)
    strain = load = 0.0
    begin = time.process_time()
    for number, stage in enumerate(frame.stages, 1):
        ops.pattern("Plain", number, 1)
        for k, values in frame.loads.items():
            ops.load(k + 1, *map(float, (stage.load - load) * values))
        ops.wipeAnalysis()
        ops.constraints("Plain")
        ops.numberer("RCM")
        ops.system("BandGeneral" if len(frame.conn) < 500 else "SparseSYM")
        ops.test("NormDispIncr", tolerance * np.ptp(frame.X, axis=0).max(), iterations, 0)
        ops.algorithm("Newton")
        ops.integrator("LoadControl", 1.0 / steps)
        ops.analysis("Static")
        ops.setTime(0.0)
        for step in range(1, steps + 1):
            if stage.strain != strain:
                for (_, eps0), elements in of_kind.items():
                    now = strain + step / steps * (stage.strain - strain)
                    ops.setParameter("-val", float(-now * eps0), "-ele", *elements, "epsInit")
            if ops.analyze(1) != 0:
                raise RuntimeError(f"step {step} of {steps} failed")
        ops.loadConst("-time", 0.0)
        strain, load = stage.strain, stage.load
    seconds = time.process_time() - begin
    return [ops.nodeDisp(frame.watch + 1, d) for d in (1, 2, 3)], seconds


def kinds_of(frame):
    return [(int(section), float(eps0)) for section, eps0 in zip(frame.sec_of, frame.eps0)]
