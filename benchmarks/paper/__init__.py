"""The paper's section 5 beside this program: runs of its models, where they cross, statements, figures."""
