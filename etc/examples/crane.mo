model Crane "A trolley with a load on a rope"
  parameter Real M(unit = "kg") = 2.0;
  parameter Real m(unit = "kg") = M/4 "the load";
  parameter Modelica.Units.SI.Length L = 1.5;
  constant Real g = 9.81;
  input Real F = 0;
  Real s(start = 0, fixed = true) "place of the trolley", v;
  Real x(start = 0.5), y(start = -1.4), u, w;
  Real lambda;
equation
  // the trolley
  der(s) = v;
  M*der(v) = F + lambda*(x - s);
  /* the load, on a rope
     of length L */
  der(x) = u;
  der(y) = w;
  m*der(u) = -lambda*(x - s);
  m*der(w) = -lambda*y - m*g;
  (x - s)^2 + y^2 = L^2;
  annotation(experiment(StopTime = 3, Interval = 0.1));
end Crane;
