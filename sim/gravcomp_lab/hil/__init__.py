"""The robot in the physics engine, gc_system in the loop."""
