"""The fitted model in a closed loop: a leg whose knee is a four-bar linkage driven by two muscles."""
