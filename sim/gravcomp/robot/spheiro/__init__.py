"""The Sphe.I.Ro.: parameters, kinematics, statics, workspace."""
