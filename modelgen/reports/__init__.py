"""What the questions leave behind: the response of a driveline, its report, tables, figures and limits, in a folder of their own.

Plain Python, for notebooks and for the command line alike: a report is told whom to tell how far it is (``progress``), and raises
what it cannot do. Stands below ``plots``; ``cli`` reads options, calls one of these, and says where the results are.
"""
