"""An engine that shares no equation with modelgen looks at the same driveline: ``comparison``, and its ``mujoco_model``.

Needs no other room.
"""
