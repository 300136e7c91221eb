! Particles to a field with gradient and report, and a run of the material point method: the same in C++, C, Fortran
! and Python, with the same output (field.output). The argument is a problem file.
program field
  use recon
  implicit none
  real(c_double), target :: x(2000), y(2000), u(2000), targets(2, 9), value(9), gradient(2, 9)
  real(c_double) :: degree(9)
  real(c_double), pointer :: v(:, :), mass(:, :)
  type(recon_options) :: options
  type(recon_fit) :: fit
  type(recon_operator) :: slopes
  type(recon_simulation) :: disks
  type(recon_array) :: array
  character(len=1) :: no_settings(0)
  character(len=512) :: problem
  integer :: i

  x = [(mod(i * 0.7548776662466927_c_double, 1.0_c_double), i = 1, 2000)]
  y = [(mod(i * 0.5698402909980532_c_double, 1.0_c_double), i = 1, 2000)]
  u = x * (x + y)
  targets(1, :) = [(0.25_c_double * (1 + mod(i, 3)), i = 0, 8)]
  targets(2, :) = [(0.25_c_double * (1 + i / 3), i = 0, 8)]

  call must(recon_options_new(options))
  call must(recon_set(options, 'degree', 1))
  call must(recon_set(options, 'radius', 0.1_c_double))
  call must(recon_reconstruct(recon_array_of(x, y), recon_array_of(targets), options, fit))
  call must(recon_fit_apply(fit, recon_array_of(u), recon_array_of(value)))
  call must(recon_fit_operator(fit, 'gradient', slopes))
  call must(recon_operator_apply(slopes, recon_array_of(u), recon_array_of(gradient)))
  call must(recon_fit_report(fit, 'degree', degree))
  print '(i0, a, i0, a, f8.6)', count(degree == 1), ' of ', recon_fit_targets(fit), &
      ' targets with degree 1, largest error ', maxval(abs(value - targets(1, :) * (targets(1, :) + targets(2, :))))
  print '(a, f8.6, 2(a, f8.6), a)', 'u(0.5, 0.5) = ', value(5), ', gradient (', gradient(1, 5), ', ', gradient(2, 5), ')'
  call recon_operator_free(slopes)
  call recon_fit_free(fit)
  call recon_options_free(options)

  call get_command_argument(1, problem)
  call must(recon_simulation_new(problem, no_settings, disks))
  call must(recon_simulation_run_until(disks, 0.5_c_double))
  call must(recon_simulation_array(disks, 'v', array))
  call recon_numbers_of(array, v)
  call must(recon_simulation_array(disks, 'mass', array))
  call recon_numbers_of(array, mass)
  print '(i0, a, f4.2, a, f8.6)', recon_simulation_particles(disks), ' particles at t = ', recon_simulation_time(disks), &
      ', kinetic energy ', sum(0.5_c_double * mass(1, :) * sum(v**2, dim=1))
  call recon_simulation_free(disks)

contains

  subroutine must(status)
    integer(c_int), intent(in) :: status
    if (status == RECON_OK) return
    print '(a)', recon_message()
    stop 1
  end subroutine must
end program field
