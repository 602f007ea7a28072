"""How does a block that lands on one foot come to rest?

A block with two feet falls from 2 cm, tilted by 0.1 rad, on rough level ground; both contacts are
rigid, with restitution 0.5. The feet hit in turn until the bounces have died out. SI units.
"""

import painleve_sym as ps

law = ps.laws.rigid(e=0.5)
start = {"y_A": 0.02, "theta": 0.1}
run = ps.simulate("block-two-feet", law, start, parameters={"beta": 0.0}, t_end=1.5)
for event in run.events_of("touchdown")[:6]:
    print(f"{event.time:.6f} s  foot {event.contact} touches the ground")
print(f"{len(run.events)} events, ended: {run.stop_reason.label}")
figure = run.plot()
