% The pendulum of MATLAB's guide to differential-algebraic equations
syms x(t) y(t) T(t) m r g
eqn1 = m*diff(x(t), t, 2) == T(t)/r*x(t);
eqn2 = m*diff(y(t), t, 2) == T(t)/r*y(t) - m*g;
eqn3 = x(t)^2 + y(t)^2 == r^2;
m = 1; r = 1.5; g = 9.81;
eqns = [eqn1, eqn2, eqn3];
vars = [x(t); y(t); T(t)];
