"""What the rules of the trade allow: ``check`` holds values by name against the ``rulebook``, data in ``rules/``.

``separation`` gives the margins that rules ask of natural frequencies. Below ``linear`` and ``time_domain``.
"""
