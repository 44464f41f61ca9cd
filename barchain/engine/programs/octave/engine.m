% A chain of rigid bars in orbit: reads a request of barchain, writes samples and a result.
%
% Unknowns are the place and velocity of the centre of mass, and each bar's angle and rate, so joints stay closed. The
% reactions solve a linear system. Runge-Kutta of order 4, equal steps. Vectors are complex numbers. In Matlab the
% functions stand at the end, and the names of the files are arguments of a function instead of `argv()`.
1;

% Derivative of the state [centre of mass; its velocity; angles; rates], and the reactions on bars from the next bar.
function [slope, reaction] = derivative(y, p)
  n = p.bars;
  com = complex(y(1), y(2));
  u = exp(1i * y(5 : 4 + n));
  rate = y(5 + n : end);
  h = p.length / 2;
  d = cumsum(h .* u) + [0; cumsum(h(1 : end - 1) .* u(1 : end - 1))];  % from the first bar's left end on
  d = d - sum(p.mass .* d) / sum(p.mass);
  r0 = abs(com);
  pull = p.gravity * p.mu / r0 ^ 3;
  z = com + d;
  q = real((com + z) .* conj(d)) / r0 ^ 2;
  g = -pull * (d + expm1(-1.5 * log1p(q)) .* z);  % less that at the centre of mass, without subtracting large numbers
  moment = real(u .* conj(z)) .* real(1i * u .* conj(z)) / r0 ^ 2;
  torque = p.gradient * 3 * pull * (1 + q) .^ -2.5 .* p.inertia .* moment;
  % Accelerations of both ends of each bar without reactions, and what a force at an end adds at either end.
  turn = h .* (1i * torque ./ p.inertia - rate .^ 2) .* u;
  right = g(2 : end) - turn(2 : end) - (g(1 : end - 1) + turn(1 : end - 1));
  a = zeros(2 * n - 2);
  for bar = 1 : n
    across = h(bar) * [-imag(u(bar)); real(u(bar))];
    near = eye(2) / p.mass(bar) + across * across' / p.inertia(bar);
    far = -eye(2) / p.mass(bar) + across * across' / p.inertia(bar);
    left_joint = 2 * bar - 3 : 2 * bar - 2;
    right_joint = 2 * bar - 1 : 2 * bar;
    if bar > 1
      a(left_joint, left_joint) = a(left_joint, left_joint) + near;
    end
    if bar < n
      a(right_joint, right_joint) = a(right_joint, right_joint) + near;
    end
    if bar > 1 && bar < n
      a(left_joint, right_joint) = far;
      a(right_joint, left_joint) = far;
    end
  end
  force = a \ reshape([real(right).'; imag(right).'], [], 1);
  reaction = complex(force(1 : 2 : end), force(2 : 2 : end));
  both = [reaction; 0] + [0; reaction];
  acceleration = sum(p.mass .* g) / sum(p.mass) - pull * com;
  turned = (torque + h .* real(1i * u .* conj(both))) ./ p.inertia;
  slope = [y(3); y(4); real(acceleration); imag(acceleration); rate; turned];
end

function y = step(y, h, p)
  k1 = derivative(y, p);
  k2 = derivative(y + h / 2 * k1, p);
  k3 = derivative(y + h / 2 * k2, p);
  k4 = derivative(y + h * k3, p);
  y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
end

files = argv();
request = jsondecode(fileread(files{1}));
scene = request.scene;
p.bars = request.bars;
p.mu = scene.central_body.mu_m3_s2;
p.mass = scene.chain.mass_kg(:);
p.length = scene.chain.length_m(:);
p.inertia = scene.chain.inertia_kg_m2(:);
p.gravity = ~strcmp(scene.effects.gravity, "none");
p.gradient = strcmp(scene.effects.gravity, "gradient");
start = request.start;
y = [start.com_m(:); start.com_velocity_m_s(:); start.angle_rad(:); start.rate_rad_s(:)];
t = request.sample_times_s(:);
h = request.setting.step_s;

rows = zeros(numel(t), 5 + 2 * p.bars + 2 * (p.bars - 1));
steps = 0;
begun = tic();
for k = 1 : numel(t)
  if k > 1
    for left = 1 : round((t(k) - t(k - 1)) / h)
      y = step(y, h, p);
      steps = steps + 1;
    end
  end
  [~, reaction] = derivative(y, p);
  rows(k, :) = [t(k), y.', reshape([real(reaction).'; imag(reaction).'], 1, [])];
end
seconds = toc(begun);

header = "t_s,com_x_m,com_y_m,com_vx_m_s,com_vy_m_s";
header = [header, sprintf(",angle_%d_rad", 1 : p.bars), sprintf(",rate_%d_rad_s", 1 : p.bars)];
for joint = 1 : p.bars - 1
  header = [header, sprintf(",reaction_%d_x_N,reaction_%d_y_N", joint, joint)];
end
table = fopen(files{2}, "w");
fprintf(table, "%s\n", header);
fprintf(table, [repmat("%.17g,", 1, size(rows, 2) - 1), "%.17g\n"], rows.');
fclose(table);
result = fopen(files{3}, "w");
fprintf(result, '{"version": 1, "seconds": %.9g, "steps": %d}', seconds, steps);
fclose(result);
