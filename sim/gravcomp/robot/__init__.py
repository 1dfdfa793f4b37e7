"""The robot: parameters, kinematics, statics, workspace, and the MuJoCo prototype."""
