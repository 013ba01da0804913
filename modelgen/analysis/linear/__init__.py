"""The driveline made linear about an operating point: free vibration, then vibration under what excites it.

``model`` is the linear model itself. Free: ``modal`` on ``natural_modes``, ``lowest_modes`` (by ``elimination``) and
``energy_shares``; ``sensitivity`` on ``parameter_directions``. Under ``excitation``, at ``speeds``: ``campbell``, ``forced`` on
``frequency_response`` and ``synthesis``, with ``speed_ratios`` and ``shear_stress``; read from those: ``gear_hammer``,
``phase_vectors``. ``linear_remarks`` (``kinks``) says what is to be known of the matrices; ``coupled_slopes`` is for those that
are not symmetric. The first room.
"""
