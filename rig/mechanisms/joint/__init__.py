"""The wide-angle spherical joint on four pneumatic wires."""
