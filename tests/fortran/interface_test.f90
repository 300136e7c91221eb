! The module for Fortran: its arrays as they are, and what it refuses.
program interface_test
  use recon
  use, intrinsic :: ieee_arithmetic
  implicit none
  integer, parameter :: side = 12, n = side * side, m = 9
  real(c_double), target :: points(2, n), x(n), y(n), u(n), targets(2, m), values(m), slopes(2, m), forces(n)
  integer :: failures = 0, i
  character(len=256) :: dump

  do i = 1, n
    points(1, i) = (mod(i, side) + 0.3_c_double * sin(7.0_c_double * i)) / side
    points(2, i) = ((i - 1) / side + 0.3_c_double * cos(5.0_c_double * i)) / side
  end do
  x = points(1, :)
  y = points(2, :)
  u = 1 + 2 * x - 3 * y
  do i = 1, m
    targets(1, i) = 0.3_c_double + 0.15_c_double * mod(i, 3)
    targets(2, i) = 0.3_c_double + 0.15_c_double * ((i - 1) / 3)
  end do

  call check(recon_abi_version() == 1 .and. index(recon_version(), '.') > 0, 'version')
  call check(recon_message() == '', 'no message yet')
  call linear_fields()
  call layouts()
  call sources_and_grids()
  call slips()
  call get_command_argument(1, dump)
  if (dump /= '') call files()
  if (failures > 0) stop 1

contains

  subroutine check(holds, what)
    logical, intent(in) :: holds
    character(len=*), intent(in) :: what
    if (holds) return
    failures = failures + 1
    print '(4a)', 'failed: ', what, '; message: ', recon_message()
  end subroutine check

  subroutine linear_fields()
    type(recon_options) :: options
    type(recon_fit) :: fit
    type(recon_operator) :: gradient, value
    real(c_double) :: degree(m)
    call check(recon_options_new(options) == RECON_OK, 'options')
    call check(recon_set(options, 'degree', 1) == RECON_OK, 'degree')
    call check(recon_set(options, 'radius', 0.3_c_double) == RECON_OK, 'radius')
    call check(recon_set(options, 'method', 'imls') == RECON_OK, 'method')
    call check(recon_reconstruct(recon_array_of(points), recon_array_of(targets), options, fit) == RECON_OK, 'fit')
    call check(recon_fit_targets(fit) == m .and. recon_fit_particles(fit) == n, 'sizes')
    call check(recon_fit_apply(fit, recon_array_of(u), recon_array_of(values)) == RECON_OK, 'apply')
    call check(maxval(abs(values - (1 + 2 * targets(1, :) - 3 * targets(2, :)))) < 1e-12_c_double, 'values')
    call check(recon_fit_operator(fit, 'gradient', gradient) == RECON_OK, 'gradient')
    call check(recon_operator_components(gradient, 1) == 2, 'components')
    call check(recon_operator_apply(gradient, recon_array_of(u), recon_array_of(slopes)) == RECON_OK, 'apply gradient')
    call check(maxval(abs(slopes(1, :) - 2)) < 1e-10_c_double .and. maxval(abs(slopes(2, :) + 3)) < 1e-10_c_double, 'slopes')
    call check(recon_fit_report(fit, 'degree', degree) == RECON_OK, 'report')
    call check(all(degree == 1), 'degree of each target')
    call check(recon_fit_apply_transpose(fit, recon_array_of(values), recon_array_of(forces)) == RECON_OK, 'transpose')
    call check(abs(sum(values**2) - sum(forces * u)) < 1e-11_c_double, 'adjoint')
    call check(recon_operator_apply_transpose(gradient, recon_array_of(slopes), recon_array_of(forces)) == RECON_OK, &
        'transposed gradient')
    call check(abs(sum(slopes**2) - sum(forces * u)) < 1e-9_c_double, 'adjoint gradient')
    call check(recon_fit_operator(fit, 'value', value) == RECON_OK, 'value')
    call check(recon_operator_add(value, 1.0_c_double, value) == RECON_OK, 'sum')
    call check(recon_operator_apply(value, recon_array_of(u), recon_array_of(slopes(1, :))) == RECON_OK, 'apply sum')
    call recon_operator_free(value)
    call recon_operator_free(gradient)
    call recon_fit_free(fit)
    call recon_options_free(options)
  end subroutine linear_fields

  ! Arrays of any strides are read and written where they lie.
  subroutine layouts()
    type(recon_options) :: options
    type(recon_fit) :: fit
    real(c_double), target :: wide(5, 2 * n), out(3, 2, m), one(m), again(m)
    real(c_float), target :: sx(n), sy(n), st(2, m), su(n), sv(m)
    call check(recon_options_new(options) == RECON_OK, 'options')
    wide = -1
    wide(2, ::2) = x
    wide(4, ::2) = y
    call check(recon_reconstruct(recon_array_of(x, y), recon_array_of(targets), options, fit) == RECON_OK, 'axes')
    call check(recon_fit_apply(fit, recon_array_of(u), recon_array_of(one)) == RECON_OK, 'apply')
    call recon_fit_free(fit)
    call check(recon_reconstruct(recon_array_of(wide(2:4:2, ::2)), recon_array_of(targets), options, fit) == RECON_OK, 'wide')
    call check(recon_fit_apply(fit, recon_array_of(u), recon_array_of(again)) == RECON_OK, 'apply wide')
    call check(all(one == again), 'the same bits')
    out = -1
    call check(recon_fit_apply(fit, recon_array_of(x, y), recon_array_of(out(1:3:2, 2, :))) == RECON_OK, 'into a section')
    call check(maxval(abs(out(1, 2, :) - targets(1, :))) < 1e-12_c_double, 'first component')
    call check(maxval(abs(out(3, 2, :) - targets(2, :))) < 1e-12_c_double, 'second component')
    call check(all(out(2, :, :) == -1) .and. all(out(:, 1, :) == -1), 'nothing else')
    call recon_fit_free(fit)
    call check(recon_reconstruct(recon_array_of(wide(2, ::2), y), recon_array_of(targets), options, fit) == &
        RECON_INVALID_ARGUMENT, 'axes of two strides')
    sx = real(x, c_float)
    sy = real(y, c_float)
    st = real(targets, c_float)
    su = real(u, c_float)
    call check(recon_reconstruct(recon_array_of(sx, sy), recon_array_of(st), options, fit) == RECON_OK, 'single precision')
    call check(recon_fit_apply(fit, recon_array_of(su), recon_array_of(sv)) == RECON_OK, 'apply in single precision')
    call check(maxval(abs(sv - one)) < 1e-4_c_double, 'values in single precision')
    call recon_fit_free(fit)
    call recon_options_free(options)
  end subroutine layouts

  subroutine sources_and_grids()
    type(recon_options) :: options, rule
    type(recon_sources) :: sources
    type(recon_fit) :: fit
    type(recon_grid) :: grid
    real(c_double), target :: density(m), mass(n), nodes(12), gradients(2, 12)
    call check(recon_options_new(options) == RECON_OK .and. recon_options_new(rule) == RECON_OK, 'options')
    call check(recon_options_periodic(options, 1, -0.1_c_double, 1.1_c_double) == RECON_OK, 'periodic')
    call check(recon_set(options, 'particle_weights', [(1.0_c_double, i=1, n)]) == RECON_OK, 'weights')
    call check(recon_sources_new(recon_array_of(points), options, sources) == RECON_OK, 'sources')
    call check(recon_sources_size(sources) == n, 'size')
    call check(recon_set(rule, 'nearest', 12) == RECON_OK, 'nearest')
    call check(recon_reconstruct_from(sources, recon_array_of(targets), rule, fit) == RECON_OK, 'fit from sources')
    call check(recon_sources_update(sources, recon_array_of(points), [(2.0_c_double, i=1, n)]) == RECON_OK, 'update')
    call check(recon_fit_apply(fit, recon_array_of(u), recon_array_of(values)) == RECON_INVALID_ARGUMENT, 'stale')
    call check(recon_fit_update(fit, recon_array_of(targets)) == RECON_OK, 'update of the fit')
    call check(recon_fit_apply_limited(fit, recon_array_of(u), 'range', recon_array_of(values)) == RECON_OK, 'limited')
    mass = 2.0_c_double / n
    call recon_options_free(rule)
    call check(recon_options_new(rule) == RECON_OK .and. recon_set(rule, 'radius', 0.3_c_double) == RECON_OK, 'radius')
    call check(recon_kernel_sum(sources, recon_array_of(targets), recon_array_of(mass), rule, recon_array_of(density)) &
        == RECON_OK, 'kernel sum')
    call check(density(5) > 1.5_c_double .and. density(5) < 2.5_c_double, 'density')
    grid = recon_grid(2, [0.3_c_double, 0.3_c_double, 0.0_c_double], [0.1_c_double, 0.15_c_double, 0.0_c_double], &
        [4_c_size_t, 3_c_size_t, 1_c_size_t])
    call check(recon_on_grid(recon_array_of(points), recon_array_of(u), grid, rule, recon_array_of(nodes), 'diffuse', &
        recon_array_of(gradients)) == RECON_OK, 'grid')
    call check(abs(nodes(6) - (1 + 2 * 0.4_c_double - 3 * 0.45_c_double)) < 1e-11_c_double, 'node 6')
    call check(maxval(abs(gradients(1, :) - 2)) < 1e-9_c_double, 'gradients at nodes')
    call recon_fit_free(fit)
    call recon_sources_free(sources)
    call recon_options_free(options)
    call recon_options_free(rule)
  end subroutine sources_and_grids

  subroutine slips()
    type(recon_options) :: options
    type(recon_fit) :: fit
    call check(recon_options_new(options) == RECON_OK, 'options')
    call check(recon_set(options, 'raduis', 1.0_c_double) == RECON_INVALID_ARGUMENT, 'raduis')
    call check(recon_message() == "option = 'raduis': is not known; did you mean 'radius'?", 'its message')
    call check(recon_set(options, 'method', 'imsl') == RECON_INVALID_ARGUMENT, 'imsl')
    call check(index(recon_message(), "did you mean 'imls'") > 0, 'its message')
    x = points(1, :)
    x(7) = ieee_value(x(7), ieee_quiet_nan)
    call check(recon_reconstruct(recon_array_of(x, y), recon_array_of(targets), options, fit) == RECON_INVALID_ARGUMENT, 'NaN')
    call check(index(recon_message(), 'coordinate x of point 6') > 0, 'its message')  ! counted from 0
    call recon_fit_free(fit)
    call recon_options_free(options)
  end subroutine slips

  subroutine files()
    type(recon_table) :: table
    type(recon_array) :: at
    real(c_double), pointer :: vx(:)
    call check(recon_read(trim(dump), -1, table) == RECON_OK, 'read')
    call check(recon_table_size(table) == 3000, 'particles')
    call check(recon_table_column(table, 'vx', vx) == RECON_OK, 'column')
    call check(size(vx) == 3000 .and. maxval(vx) > 0, 'numbers of the column')
    call check(recon_table_positions(table, at) == RECON_OK .and. at%components == 3, 'positions')
    call recon_table_free(table)
    call check(recon_read('nowhere.dump', -1, table) == RECON_FILE_ERROR, 'no such file')
    call check(index(recon_message(), 'nowhere.dump') > 0, 'its message')
  end subroutine files
end program interface_test
