"""Kratos Multiphysics: CrBeamElement3D2N, a corotational Timoshenko beam.

Contraction is its BEAM_INITIAL_STRAIN_VECTOR. Newton by its own strategy, block builder, Eigen's sparse LU.
"""

import time

import numpy as np

THEORY = "shear"
PACKAGE = "KratosMultiphysics"


def solve(frame, steps, tolerance=1e-8, iterations=60):
    import KratosMultiphysics as K
    import KratosMultiphysics.LinearSolversApplication  # noqa: F401 - registers the solver
    import KratosMultiphysics.StructuralMechanicsApplication as S
    from KratosMultiphysics import python_linear_solver_factory as factory

    K.Logger.GetDefaultOutput().SetSeverity(K.Logger.Severity.WARNING)
    model = K.Model()
    part = model.CreateModelPart("frame")
    part.SetBufferSize(2)
    part.ProcessInfo[K.DOMAIN_SIZE] = 3
    for variable in (K.DISPLACEMENT, K.REACTION, K.ROTATION, K.REACTION_MOMENT, S.POINT_LOAD, S.POINT_MOMENT, K.VOLUME_ACCELERATION):
        part.AddNodalSolutionStepVariable(variable)
    for k, x in enumerate(frame.X):
        part.CreateNewNode(k + 1, *map(float, x))
    for i, s in enumerate(frame.sec):
        own = part.CreateNewProperties(i + 1)
        values = {
            K.YOUNG_MODULUS: s.E, K.POISSON_RATIO: s.E / (2 * s.G) - 1, K.DENSITY: 1e-9, S.CROSS_AREA: s.A, S.I22: s.I,
            S.I33: s.I, S.TORSIONAL_INERTIA: s.J, S.AREA_EFFECTIVE_Y: s.As, S.AREA_EFFECTIVE_Z: s.As,
        }
        for variable, value in values.items():
            own.SetValue(variable, value)
        own.SetValue(K.CONSTITUTIVE_LAW, S.BeamConstitutiveLaw())
    for e, (i, j) in enumerate(frame.conn):
        part.CreateNewElement("CrBeamElement3D2N", e + 1, [int(i) + 1, int(j) + 1], part.Properties[int(frame.sec_of[e]) + 1])
    for k in frame.loads:
        part.CreateNewCondition("PointLoadCondition3D1N", 2 * k + 1, [k + 1], part.Properties[1])
        part.CreateNewCondition("PointMomentCondition3D1N", 2 * k + 2, [k + 1], part.Properties[1])
    displacement = (K.DISPLACEMENT_X, K.DISPLACEMENT_Y, K.DISPLACEMENT_Z)
    unknowns = {
        K.DISPLACEMENT_X: K.REACTION_X, K.DISPLACEMENT_Y: K.REACTION_Y, K.DISPLACEMENT_Z: K.REACTION_Z,
        K.ROTATION_X: K.REACTION_MOMENT_X, K.ROTATION_Y: K.REACTION_MOMENT_Y, K.ROTATION_Z: K.REACTION_MOMENT_Z,
    }
    for unknown, reaction in unknowns.items():
        K.VariableUtils().AddDof(unknown, reaction, part)
    for k in frame.clamped:
        for unknown in unknowns:
            part.Nodes[k + 1].Fix(unknown)
    linear = factory.ConstructSolver(K.Parameters('{"solver_type": "LinearSolversApplication.sparse_lu"}'))
    size = float(np.ptp(frame.X, axis=0).max())
    strategy = K.ResidualBasedNewtonRaphsonStrategy(
        part, K.ResidualBasedIncrementalUpdateStaticScheme(), K.DisplacementCriteria(tolerance, 0.1 * tolerance * size),
        K.ResidualBasedBlockBuilderAndSolver(linear), iterations, True, False, True,
    )
    strategy.SetEchoLevel(0)
    strategy.Initialize()
    contracting = [(e + 1, float(eps0)) for e, eps0 in enumerate(frame.eps0) if eps0 != 0]
    strain = load = moment = 0.0
    begin = time.process_time()
    for stage in frame.stages:
        for step in range(1, steps + 1):
            part_of = step / steps
            moment += 1.0
            part.CloneTimeStep(moment)
            part.ProcessInfo[K.STEP] += 1
            if stage.strain != strain:
                now = strain + part_of * (stage.strain - strain)
                for e, eps0 in contracting:
                    part.Elements[e].SetValue(S.BEAM_INITIAL_STRAIN_VECTOR, K.Vector([now * eps0, 0, 0]))
            now = load + part_of * (stage.load - load)
            for k, values in frame.loads.items():
                part.Conditions[2 * k + 1].SetValue(S.POINT_LOAD, K.Array3([float(v) for v in now * values[:3]]))
                part.Conditions[2 * k + 2].SetValue(S.POINT_MOMENT, K.Array3([float(v) for v in now * values[3:]]))
            strategy.InitializeSolutionStep()
            strategy.Predict()
            converged = strategy.SolveSolutionStep()
            strategy.FinalizeSolutionStep()
            if not converged:
                raise RuntimeError(f"step {step} of {steps} failed")
        strain, load = stage.strain, stage.load
    seconds = time.process_time() - begin
    node = part.Nodes[frame.watch + 1]
    return [node.GetSolutionStepValue(d) for d in displacement], seconds
