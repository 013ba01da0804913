"""What was recorded, beside what was computed: ``measurement`` reads channels, ``compare`` lays them over a run.

``exchange.delimited_text`` is the border where foreign tables come in, ``common_clock`` and ``signals`` bring both onto one
time. Needs no other room.
"""
