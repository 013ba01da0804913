"""Many points of one case, on all cores or a cluster, safe from kills: ``sweep`` is the question, ``SweepResult`` the answer.

What is asked: ``points``, ``collect``. What computes: ``batch``, here, in the processes of a ``crew`` (``job``, ``wire``,
``worker``) or on a ``cluster``, after the list of ``work``. What is kept: ``shard``, ``store``, ``record``, ``result``.
Needs no other room, but for the settled window of a model that is given instead of a case.
"""
