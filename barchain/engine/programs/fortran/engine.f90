! A chain of rigid bars in orbit: reads a request of barchain, writes samples and a result.
! Unknowns are the place and velocity of the centre of mass, and each bar's angle and rate, so joints stay closed. The
! reactions solve a linear system. Runge-Kutta of order 4, equal steps. Vectors are complex numbers.
module chain
  implicit none
  integer, parameter :: real64 = kind(1d0)
  complex(real64), parameter :: i = (0d0, 1d0)
  real(real64), parameter :: one(2, 2) = reshape([1d0, 0d0, 0d0, 1d0], [2, 2])
  integer :: bars
  logical :: gravity, gradient
  real(real64) :: mu
  real(real64), allocatable :: mass(:), length(:), inertia(:)
  character(:), allocatable :: request
  complex(real64), allocatable :: reaction(:) ! (0:bars), on bar j from bar j+1; zero at both ends
contains
  elemental real(real64) function dot(a, b)
    complex(real64), intent(in) :: a, b
    dot = real(a * conjg(b), real64)
  end function

  ! Derivative of the state (centre of mass, its velocity, angles, rates); sets the reactions.
  function derivative(y) result(slope)
    real(real64), intent(in) :: y(:)
    real(real64) :: slope(size(y)), a(2, bars - 1, 2, bars - 1), b(2, bars - 1), r0, pull, n(2), turned(2, 2)
    real(real64), dimension(bars) :: rate, half, q, e, torque
    complex(real64), dimension(bars) :: u, d, z, g
    complex(real64) :: com, acceleration, ends
    integer :: bar, joint, other
    com = cmplx(y(1), y(2), real64)
    rate = y(5 + bars:)
    u = exp(i * y(5:4 + bars))
    half = length / 2
    d = [(half(bar) * u(bar) + sum(length(:bar - 1) * u(:bar - 1)), bar=1, bars)] ! from the first bar's left end on
    d = d - sum(mass * d) / sum(mass)
    r0 = abs(com)
    pull = merge(mu / r0**3, 0d0, gravity)
    z = com + d
    q = dot(com + z, d) / r0**2
    e = (1 + q) * sqrt(1 + q) ! (1+q)^(-3/2) - 1 without cancellation
    e = -q * (3 + 3 * q + q**2) / (e * (1 + e))
    g = -pull * (d + e * z) ! gravity less that at the centre of mass
    torque = merge(3 * pull * (1 + q)**(-2.5d0) * inertia * dot(u, z) * dot(i * u, z) / r0**2, 0d0, gradient)
    a = 0
    do joint = 1, bars - 1 ! both bars have one acceleration at the joint
      ends = g(joint + 1) - g(joint)
      do bar = joint, joint + 1
        ends = ends - half(bar) * (i * torque(bar) / inertia(bar) - rate(bar)**2) * u(bar)
        n = [-aimag(u(bar)), real(u(bar))]
        turned = half(bar)**2 / inertia(bar) * spread(n, 2, 2) * spread(n, 1, 2)
        other = merge(joint - 1, joint + 1, bar == joint) ! joint at the other end of the bar
        a(:, joint, :, joint) = a(:, joint, :, joint) + turned + one / mass(bar)
        if (other >= 1 .and. other < bars) a(:, joint, :, other) = a(:, joint, :, other) + turned - one / mass(bar)
      end do
      b(:, joint) = [real(ends), aimag(ends)]
    end do
    call solve(2 * (bars - 1), a, b)
    reaction(1:bars - 1) = cmplx(b(1, :), b(2, :), real64)
    acceleration = sum(mass * g) / sum(mass) - pull * com
    slope(:4) = [y(3), y(4), real(acceleration), aimag(acceleration)]
    slope(5:4 + bars) = rate
    slope(5 + bars:) = (torque + half * dot(i * u, reaction(1:) + reaction(:bars - 1))) / inertia
  end function

  ! Solve a x = b by elimination; the system is positive definite. b becomes x.
  subroutine solve(n, a, b)
    integer, intent(in) :: n
    real(real64), intent(inout) :: a(n, n), b(n)
    integer :: k, row
    do k = 1, n
      do row = k + 1, min(k + 3, n) ! entries up to three places off the diagonal
        b(row) = b(row) - a(row, k) / a(k, k) * b(k)
        a(row, k + 1:) = a(row, k + 1:) - a(row, k) / a(k, k) * a(k, k + 1:)
      end do
    end do
    do k = n, 1, -1
      b(k) = (b(k) - sum(a(k, k + 1:) * b(k + 1:))) / a(k, k)
    end do
  end subroutine

  function step(y, h) result(after)
    real(real64), intent(in) :: y(:), h
    real(real64), dimension(size(y)) :: after, k1, k2, k3, k4
    k1 = derivative(y)
    k2 = derivative(y + h / 2 * k1)
    k3 = derivative(y + h / 2 * k2)
    k4 = derivative(y + h * k3)
    after = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
  end function

  ! Numbers of "key" behind "table" in the request.
  function numbers(table, key) result(found)
    character(*), intent(in) :: table, key
    real(real64), allocatable :: found(:)
    character(:), allocatable :: list
    integer :: at, k
    at = index(request, '"' // table // '":')
    at = at + index(request(at:), '"' // key // '":') + len(key) + 2
    at = at + verify(request(at:), ' [') - 1
    list = request(at:at + scan(request(at:), merge(']', ',', request(at - 1:at - 1) == '[')) - 2)
    allocate (found(count([(list(k:k) == ',', k=1, len(list))]) + 1))
    read (list, *) found
  end function
end module

program engine
  use chain
  implicit none
  character(4096) :: file(3)
  real(real64), allocatable :: y(:), t(:), slope(:)
  real(real64) :: h(1), begun, ended
  integer :: k, length_B, left, steps = 0
  call get_command_argument(1, file(1))
  call get_command_argument(2, file(2))
  call get_command_argument(3, file(3))
  open (1, file=trim(file(1)), access='stream', form='unformatted', status='old')
  inquire (1, size=length_B)
  allocate (character(length_B) :: request)
  read (1) request
  mass = numbers('chain', 'mass_kg')
  length = numbers('chain', 'length_m')
  inertia = numbers('chain', 'inertia_kg_m2')
  mu = sum(numbers('central_body', 'mu_m3_s2'))
  h = numbers('setting', 'step_s')
  t = numbers('version', 'sample_times_s')
  y = [numbers('start', 'com_m'), numbers('start', 'com_velocity_m_s'), &
       numbers('start', 'angle_rad'), numbers('start', 'rate_rad_s')]
  bars = size(mass)
  allocate (reaction(0:bars), source=(0d0, 0d0))
  gravity = index(request, '"gravity": "none"') == 0
  gradient = index(request, '"gravity": "gradient"') > 0

  open (2, file=trim(file(2)), recl=1000 + 200 * bars)
  write (2, '(a)', advance='no') 't_s,com_x_m,com_y_m,com_vx_m_s,com_vy_m_s'
  write (2, '(*(:, ",angle_", i0, "_rad"))', advance='no') (k, k=1, bars)
  write (2, '(*(:, ",rate_", i0, "_rad_s"))', advance='no') (k, k=1, bars)
  write (2, '(*(:, ",reaction_", i0, "_x_N,reaction_", i0, "_y_N"))') (k, k, k=1, bars - 1)
  call cpu_time(begun)
  do k = 1, size(t)
    do left = 1, nint((t(k) - t(max(k - 1, 1))) / h(1))
      y = step(y, h(1))
      steps = steps + 1
    end do
    slope = derivative(y)
    write (2, '(es24.16e3, *(:, ",", es24.16e3))') t(k), y, reaction(1:bars - 1)
  end do
  call cpu_time(ended)
  open (3, file=trim(file(3)))
  write (3, '(a, es12.5, a, i0, a)') '{"version": 1, "seconds": ', ended - begun, ', "steps": ', steps, '}'
end program
