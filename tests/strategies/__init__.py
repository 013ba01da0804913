"""Hypothesis strategies over what modelgen declares: drivelines, model files, broken model files, command lines.

``values`` draws from the declaration of a parameter, ``elements`` from that of a kind, ``drivelines`` joins elements to trees and
loops, ``broken`` spoils model files, ``command_lines`` draws from the declarations of the commands. A kind that is added to the
vocabulary is drawn without a line here.
"""
