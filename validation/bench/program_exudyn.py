"""Exudyn: geometrically exact beams of two nodes, in the plane and in space.

The spatial beam takes the axes of its nodes as those of its section: where elements of different directions meet, each
has a node of its own, and rigid joints tie them. There is no induced strain: the contraction a = strain eps0 is a
length of l (1 + a) and stiffnesses times 1 + a, which is the same law. Newton in its static solver, Eigen's sparse LU.
"""

import time

import numpy as np

THEORY = "shear"
PACKAGE = "exudyn"


def solve(frame, steps, tolerance=1e-8, iterations=60):
    import exudyn as exu
    import exudyn.itemInterface as items

    system = exu.SystemContainer().AddSystem()
    lengths = np.linalg.norm(frame.X[frame.conn[:, 1]] - frame.X[frame.conn[:, 0]], axis=1)
    build = plane if frame.planar else space
    nodes, elements, set_section = build(frame, system, items, exu, lengths)
    loads = []
    for k, values in frame.loads.items():
        marker = system.AddMarker(items.MarkerNodeRigid(nodeNumber=nodes[k]))
        for kind, own in ((items.Force, values[:3]), (items.Torque, values[3:])):
            if np.any(own):
                loads.append((system.AddLoad(kind(markerNumber=marker, loadVector=[0, 0, 0])), np.array(own)))
    system.Assemble()
    settings = exu.SimulationSettings()
    settings.linearSolverType = exu.LinearSolverType.EigenSparse
    settings.solutionSettings.writeSolutionToFile = False
    settings.solutionSettings.sensorsWritePeriod = 1e9
    settings.staticSolver.verboseMode = 0
    settings.staticSolver.numberOfLoadSteps = 1
    settings.staticSolver.adaptiveStep = False
    settings.staticSolver.useLoadFactor = False
    settings.staticSolver.newton.relativeTolerance = tolerance
    settings.staticSolver.newton.absoluteTolerance = tolerance
    settings.staticSolver.newton.maxIterations = iterations
    contracting = [e for e, eps0 in enumerate(frame.eps0) if eps0 != 0]
    strain = load = 0.0
    begin = time.process_time()
    for stage in frame.stages:
        for step in range(1, steps + 1):
            part = step / steps
            if stage.strain != strain:
                now = strain + part * (stage.strain - strain)
                for e in contracting:
                    scale = 1 + now * frame.eps0[e]
                    system.SetObjectParameter(elements[e], "physicsLength", lengths[e] * scale)
                    set_section(elements[e], frame.sec[frame.sec_of[e]], scale)
            now = load + part * (stage.load - load)
            for number, values in loads:
                system.SetLoadParameter(number, "loadVector", list(now * values))
            if not system.SolveStatic(settings, updateInitialValues=True, showHints=False):
                raise RuntimeError(f"step {step} of {steps} failed")
        strain, load = stage.strain, stage.load
    seconds = time.process_time() - begin
    u = system.GetNodeOutput(nodes[frame.watch], exu.OutputVariableType.Displacement)
    return [float(x) for x in u], seconds


def plane(frame, system, items, exu, lengths):
    ground = system.AddNode(items.NodePointGround())
    fixed = system.AddMarker(items.MarkerNodeCoordinate(nodeNumber=ground, coordinate=0))
    nodes = [system.AddNode(items.NodeRigidBody2D(referenceCoordinates=[x[0], x[1], 0])) for x in frame.X]
    elements = []
    for e, (i, j) in enumerate(frame.conn):
        s = frame.sec[frame.sec_of[e]]
        elements.append(system.AddObject(items.ObjectBeamGeometricallyExact2D(
            nodeNumbers=[nodes[i], nodes[j]], physicsLength=lengths[e], physicsMassPerLength=1.0,
            physicsCrossSectionInertia=1.0, physicsBendingStiffness=s.E * s.I, physicsAxialStiffness=s.E * s.A,
            physicsShearStiffness=s.G * s.As, includeReferenceRotations=False,
        )))
    for k in frame.clamped:
        for coordinate in range(3):
            marker = system.AddMarker(items.MarkerNodeCoordinate(nodeNumber=nodes[k], coordinate=coordinate))
            system.AddObject(items.CoordinateConstraint(markerNumbers=[fixed, marker]))

    def set_section(element, s, scale):
        system.SetObjectParameter(element, "physicsBendingStiffness", s.E * s.I * scale)
        system.SetObjectParameter(element, "physicsAxialStiffness", s.E * s.A * scale)
        system.SetObjectParameter(element, "physicsShearStiffness", s.G * s.As * scale)

    return nodes, elements, set_section


def space(frame, system, items, exu, lengths):
    from exudyn.utilities import RotationMatrix2EulerParameters

    def section(s, scale):
        data = exu.BeamSection()
        data.stiffnessMatrix = scale * np.diag([s.E * s.A, s.G * s.As, s.G * s.As, s.G * s.J, s.E * s.I, s.E * s.I])
        data.inertia = np.eye(3)
        data.massPerLength = 1.0
        return data

    ground = system.AddObject(items.ObjectGround())
    made = [[] for _ in frame.X]  # axes and node

    def node_for(k, axes):
        for known, node in made[k]:
            if np.abs(known - axes).max() < 1e-9:
                return node
        place = [*frame.X[k], *RotationMatrix2EulerParameters(axes)]
        made[k].append((axes, system.AddNode(items.NodeRigidBodyEP(referenceCoordinates=place))))
        return made[k][-1][1]

    elements = []
    for e, (i, j) in enumerate(frame.conn):
        tangent = (frame.X[j] - frame.X[i]) / lengths[e]
        third = np.cross(tangent, frame.up[e])
        third /= np.linalg.norm(third)
        axes = np.column_stack([tangent, np.cross(third, tangent), third])
        elements.append(system.AddObject(items.ObjectBeamGeometricallyExact(
            nodeNumbers=[node_for(i, axes), node_for(j, axes)], physicsLength=lengths[e],
            sectionData=section(frame.sec[frame.sec_of[e]], 1.0),
        )))
    nodes = [None] * len(frame.X)
    for k, own in enumerate(made):
        if not own:
            continue
        axes, nodes[k] = own[0]
        marker = system.AddMarker(items.MarkerNodeRigid(nodeNumber=nodes[k]))
        for other, node in own[1:]:
            second = system.AddMarker(items.MarkerNodeRigid(nodeNumber=node))
            system.AddObject(items.GenericJoint(markerNumbers=[marker, second], rotationMarker0=axes.T, rotationMarker1=other.T))
        if k in frame.clamped:
            held = system.AddMarker(items.MarkerBodyRigid(bodyNumber=ground, localPosition=list(frame.X[k])))
            system.AddObject(items.GenericJoint(markerNumbers=[held, marker], rotationMarker1=axes.T))

    def set_section(element, s, scale):
        system.SetObjectParameter(element, "sectionData", section(s, scale))

    return nodes, elements, set_section
