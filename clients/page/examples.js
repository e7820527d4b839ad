// Requests to start from: files of etc/examples, built in beside the page.
export const EXAMPLES = [
  ["pendulum", "Pendulum in Cartesian coordinates"], ["arm", "Telescopic arm with controls"], ["circuit", "Diode circuit"], ["ladder", "RC ladder, E x' = A x + B u"], ["sleigh", "Sleigh: constraint in velocities"],
  ["bead", "Bead on a circle: Dirac's constraints"], ["cawley", "Singular Lagrangian after Cawley"], ["sliding", "Control held on a surface"], ["turning", "Strata and symmetries"], ["operator", "Operator with coefficients in time"],
];
