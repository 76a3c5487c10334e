"""The fitted model in a closed loop: two muscles, their air and the joint they move, in time."""
