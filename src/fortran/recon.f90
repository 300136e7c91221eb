! recon for Fortran 2003: what recon/c/recon.h has, with Fortran's arrays and texts.
!
!   use recon
!   type(recon_options) :: options
!   type(recon_fit) :: fit
!   real(c_double), target :: x(n), y(n), u(n), at(2, m), v(m), slopes(2, m)
!   if (recon_options_new(options) /= RECON_OK) stop 1
!   if (recon_set(options, 'radius', 0.3_c_double) /= RECON_OK) stop recon_message()
!   if (recon_reconstruct(recon_array_of(x, y), recon_array_of(at), options, fit) /= RECON_OK) ...
!   if (recon_fit_apply(fit, recon_array_of(u), recon_array_of(v)) /= RECON_OK) ...
!
! Arrays are as Fortran has them: recon_array_of(x, y, z) takes an array for each axis or component,
! recon_array_of(a) an array a(k, n) with the k coordinates or components of each of n points together, or a(n).
! They may have any strides, are read and written where they lie, and should have the attribute target.
! Functions return RECON_OK or a status that is not, and recon_message() then says what is wrong. Particles are
! counted from 0 in lists of neighbours, as in C. What each function does stands in recon/c/recon.h.
module recon
  use, intrinsic :: iso_c_binding
  implicit none
  private

  public :: c_double, c_float, c_int, c_size_t, c_int64_t, c_int32_t
  integer(c_int), parameter, public :: RECON_OK = 0, RECON_INVALID_ARGUMENT = 1, RECON_FILE_ERROR = 2, &
      RECON_CANCELLED = 3, RECON_FAILURE = 4, RECON_NO_MEMORY = 5, RECON_UNEXPECTED = 6
  integer(c_int), parameter, public :: RECON_DOUBLE = 0, RECON_FLOAT = 1

  type, bind(c), public :: recon_array
    integer(c_size_t) :: size
    integer(c_int) :: components
    integer(c_int) :: number
    type(c_ptr) :: data
    integer(c_intptr_t) :: stride, component_stride
    type(c_ptr) :: arrays(9)
  end type recon_array

  type, bind(c), public :: recon_grid
    integer(c_int) :: dimension
    real(c_double) :: origin(3), spacing(3)
    integer(c_size_t) :: counts(3)
  end type recon_grid

  ! Handles. A copy is the same object: free one of them.
  type, public :: recon_options
    type(c_ptr) :: handle = c_null_ptr
  end type recon_options
  type, public :: recon_sources
    type(c_ptr) :: handle = c_null_ptr
  end type recon_sources
  type, public :: recon_fit
    type(c_ptr) :: handle = c_null_ptr
  end type recon_fit
  type, public :: recon_operator
    type(c_ptr) :: handle = c_null_ptr
  end type recon_operator
  type, public :: recon_table
    type(c_ptr) :: handle = c_null_ptr
  end type recon_table
  type, public :: recon_simulation
    type(c_ptr) :: handle = c_null_ptr
  end type recon_simulation

  public :: recon_abi_version, recon_version, recon_message, recon_array_of, recon_numbers_of
  public :: recon_options_new, recon_options_free, recon_set, recon_options_periodic, recon_options_neighbours
  public :: recon_options_ellipsoids
  public :: recon_sources_new, recon_sources_update, recon_sources_size, recon_sources_free, recon_kernel_sum
  public :: recon_reconstruct, recon_reconstruct_at_nodes, recon_reconstruct_from, recon_fit_update, recon_fit_free
  public :: recon_fit_targets, recon_fit_particles, recon_fit_apply, recon_fit_apply_limited
  public :: recon_fit_apply_transpose, recon_fit_report, recon_fit_operator
  public :: recon_operator_free, recon_operator_components, recon_operator_apply, recon_operator_apply_transpose
  public :: recon_operator_add, recon_on_grid
  public :: recon_read, recon_table_free, recon_table_size, recon_table_column, recon_table_positions
  public :: recon_simulation_new, recon_simulation_free, recon_simulation_dimension, recon_simulation_particles
  public :: recon_simulation_time, recon_simulation_end, recon_simulation_choose_step, recon_simulation_step
  public :: recon_simulation_run_until, recon_simulation_array

  interface recon_array_of
    module procedure doubles_1, doubles_2, double_axes_2, double_axes_3
    module procedure floats_1, floats_2, float_axes_2, float_axes_3
  end interface recon_array_of

  ! An option by name: a number, a text, or (stretch, particle_weights, radii) an array.
  interface recon_set
    module procedure set_double, set_integer, set_text, set_numbers
  end interface recon_set

  interface
    function recon_abi_version() bind(c)
      import :: c_int
      integer(c_int) :: recon_abi_version
    end function recon_abi_version
    function c_version() bind(c, name='recon_version')
      import :: c_ptr
      type(c_ptr) :: c_version
    end function c_version
    function c_message() bind(c, name='recon_message')
      import :: c_ptr
      type(c_ptr) :: c_message
    end function c_message
    pure function c_strlen(text) bind(c, name='strlen')
      import :: c_ptr, c_size_t
      type(c_ptr), value :: text
      integer(c_size_t) :: c_strlen
    end function c_strlen

    function c_options_new(options) bind(c, name='recon_options_new')
      import :: c_ptr, c_int
      type(c_ptr) :: options
      integer(c_int) :: c_options_new
    end function c_options_new
    subroutine c_options_free(options) bind(c, name='recon_options_free')
      import :: c_ptr
      type(c_ptr), value :: options
    end subroutine c_options_free
    function c_options_number(options, name, number) bind(c, name='recon_options_number')
      import :: c_ptr, c_int, c_char, c_double
      type(c_ptr), value :: options
      character(kind=c_char), intent(in) :: name(*)
      real(c_double), value :: number
      integer(c_int) :: c_options_number
    end function c_options_number
    function c_options_text(options, name, text) bind(c, name='recon_options_text')
      import :: c_ptr, c_int, c_char
      type(c_ptr), value :: options
      character(kind=c_char), intent(in) :: name(*), text(*)
      integer(c_int) :: c_options_text
    end function c_options_text
    function c_options_numbers(options, name, values, count) bind(c, name='recon_options_numbers')
      import :: c_ptr, c_int, c_char, c_double, c_size_t
      type(c_ptr), value :: options
      character(kind=c_char), intent(in) :: name(*)
      real(c_double), intent(in) :: values(*)
      integer(c_size_t), value :: count
      integer(c_int) :: c_options_numbers
    end function c_options_numbers
    function c_options_periodic(options, axis, lower, upper) bind(c, name='recon_options_periodic')
      import :: c_ptr, c_int, c_double
      type(c_ptr), value :: options
      integer(c_int), value :: axis
      real(c_double), value :: lower, upper
      integer(c_int) :: c_options_periodic
    end function c_options_periodic
    function c_options_neighbours(options, targets, offsets, indices, support) bind(c, name='recon_options_neighbours')
      import :: c_ptr, c_int, c_size_t, c_int64_t, c_int32_t, c_double
      type(c_ptr), value :: options
      integer(c_size_t), value :: targets
      integer(c_int64_t), intent(in) :: offsets(*)
      integer(c_int32_t), intent(in) :: indices(*)
      real(c_double), intent(in) :: support(*)
      integer(c_int) :: c_options_neighbours
    end function c_options_neighbours

    function c_options_ellipsoids(options, tensors) bind(c, name='recon_options_ellipsoids')
      import :: recon_array, c_ptr, c_int
      type(c_ptr), value :: options
      type(recon_array), value :: tensors
      integer(c_int) :: c_options_ellipsoids
    end function c_options_ellipsoids

    function c_sources_new(points, options, sources) bind(c, name='recon_sources_new')
      import :: recon_array, c_ptr, c_int
      type(recon_array), value :: points
      type(c_ptr), value :: options
      type(c_ptr) :: sources
      integer(c_int) :: c_sources_new
    end function c_sources_new
    function c_sources_update(sources, points, weights) bind(c, name='recon_sources_update')
      import :: recon_array, c_ptr, c_int
      type(c_ptr), value :: sources, weights
      type(recon_array), value :: points
      integer(c_int) :: c_sources_update
    end function c_sources_update
    function c_sources_size(sources) bind(c, name='recon_sources_size')
      import :: c_ptr, c_size_t
      type(c_ptr), value :: sources
      integer(c_size_t) :: c_sources_size
    end function c_sources_size
    subroutine c_sources_free(sources) bind(c, name='recon_sources_free')
      import :: c_ptr
      type(c_ptr), value :: sources
    end subroutine c_sources_free
    function c_kernel_sum(sources, targets, amounts, options, out) bind(c, name='recon_kernel_sum')
      import :: recon_array, c_ptr, c_int
      type(c_ptr), value :: sources, options
      type(recon_array), value :: targets, amounts, out
      integer(c_int) :: c_kernel_sum
    end function c_kernel_sum

    function c_reconstruct(points, targets, options, fit) bind(c, name='recon_reconstruct')
      import :: recon_array, c_ptr, c_int
      type(recon_array), value :: points, targets
      type(c_ptr), value :: options
      type(c_ptr) :: fit
      integer(c_int) :: c_reconstruct
    end function c_reconstruct
    function c_reconstruct_at_nodes(points, grid, options, fit) bind(c, name='recon_reconstruct_at_nodes')
      import :: recon_array, recon_grid, c_ptr, c_int
      type(recon_array), value :: points
      type(recon_grid), value :: grid
      type(c_ptr), value :: options
      type(c_ptr) :: fit
      integer(c_int) :: c_reconstruct_at_nodes
    end function c_reconstruct_at_nodes
    function c_reconstruct_from(sources, targets, options, fit) bind(c, name='recon_reconstruct_from')
      import :: recon_array, c_ptr, c_int
      type(c_ptr), value :: sources, options
      type(recon_array), value :: targets
      type(c_ptr) :: fit
      integer(c_int) :: c_reconstruct_from
    end function c_reconstruct_from
    function c_fit_update(fit, targets) bind(c, name='recon_fit_update')
      import :: recon_array, c_ptr, c_int
      type(c_ptr), value :: fit
      type(recon_array), value :: targets
      integer(c_int) :: c_fit_update
    end function c_fit_update
    subroutine c_fit_free(fit) bind(c, name='recon_fit_free')
      import :: c_ptr
      type(c_ptr), value :: fit
    end subroutine c_fit_free
    function c_fit_targets(fit) bind(c, name='recon_fit_targets')
      import :: c_ptr, c_size_t
      type(c_ptr), value :: fit
      integer(c_size_t) :: c_fit_targets
    end function c_fit_targets
    function c_fit_particles(fit) bind(c, name='recon_fit_particles')
      import :: c_ptr, c_size_t
      type(c_ptr), value :: fit
      integer(c_size_t) :: c_fit_particles
    end function c_fit_particles
    function c_fit_apply(fit, field, out) bind(c, name='recon_fit_apply')
      import :: recon_array, c_ptr, c_int
      type(c_ptr), value :: fit
      type(recon_array), value :: field, out
      integer(c_int) :: c_fit_apply
    end function c_fit_apply
    function c_fit_apply_limited(fit, field, limit, out) bind(c, name='recon_fit_apply_limited')
      import :: recon_array, c_ptr, c_int, c_char
      type(c_ptr), value :: fit
      type(recon_array), value :: field, out
      character(kind=c_char), intent(in) :: limit(*)
      integer(c_int) :: c_fit_apply_limited
    end function c_fit_apply_limited
    function c_fit_apply_transpose(fit, field, out) bind(c, name='recon_fit_apply_transpose')
      import :: recon_array, c_ptr, c_int
      type(c_ptr), value :: fit
      type(recon_array), value :: field, out
      integer(c_int) :: c_fit_apply_transpose
    end function c_fit_apply_transpose
    function c_fit_report(fit, name, out, count) bind(c, name='recon_fit_report')
      import :: c_ptr, c_int, c_char, c_double, c_size_t
      type(c_ptr), value :: fit
      character(kind=c_char), intent(in) :: name(*)
      real(c_double), intent(inout) :: out(*)
      integer(c_size_t), value :: count
      integer(c_int) :: c_fit_report
    end function c_fit_report
    function c_fit_operator(fit, name, op) bind(c, name='recon_fit_operator')
      import :: c_ptr, c_int, c_char
      type(c_ptr), value :: fit
      character(kind=c_char), intent(in) :: name(*)
      type(c_ptr) :: op
      integer(c_int) :: c_fit_operator
    end function c_fit_operator
    subroutine c_operator_free(op) bind(c, name='recon_operator_free')
      import :: c_ptr
      type(c_ptr), value :: op
    end subroutine c_operator_free
    function c_operator_components(op, of_field) bind(c, name='recon_operator_components')
      import :: c_ptr, c_int
      type(c_ptr), value :: op
      integer(c_int), value :: of_field
      integer(c_int) :: c_operator_components
    end function c_operator_components
    function c_operator_apply(op, field, out) bind(c, name='recon_operator_apply')
      import :: recon_array, c_ptr, c_int
      type(c_ptr), value :: op
      type(recon_array), value :: field, out
      integer(c_int) :: c_operator_apply
    end function c_operator_apply
    function c_operator_apply_transpose(op, field, out) bind(c, name='recon_operator_apply_transpose')
      import :: recon_array, c_ptr, c_int
      type(c_ptr), value :: op
      type(recon_array), value :: field, out
      integer(c_int) :: c_operator_apply_transpose
    end function c_operator_apply_transpose
    function c_operator_add(op, factor, other) bind(c, name='recon_operator_add')
      import :: c_ptr, c_int, c_double
      type(c_ptr), value :: op, other
      real(c_double), value :: factor
      integer(c_int) :: c_operator_add
    end function c_operator_add
    function c_on_grid(points, field, grid, options, out, gradients, gradients_out) bind(c, name='recon_on_grid')
      import :: recon_array, recon_grid, c_ptr, c_int
      type(recon_array), value :: points, field, out, gradients_out
      type(recon_grid), value :: grid
      type(c_ptr), value :: options, gradients
      integer(c_int) :: c_on_grid
    end function c_on_grid

    function c_read(path, frame, table) bind(c, name='recon_read')
      import :: c_ptr, c_int, c_char
      character(kind=c_char), intent(in) :: path(*)
      integer(c_int), value :: frame
      type(c_ptr) :: table
      integer(c_int) :: c_read
    end function c_read
    subroutine c_table_free(table) bind(c, name='recon_table_free')
      import :: c_ptr
      type(c_ptr), value :: table
    end subroutine c_table_free
    function c_table_size(table) bind(c, name='recon_table_size')
      import :: c_ptr, c_size_t
      type(c_ptr), value :: table
      integer(c_size_t) :: c_table_size
    end function c_table_size
    function c_table_column(table, name, column) bind(c, name='recon_table_column')
      import :: c_ptr, c_int, c_char
      type(c_ptr), value :: table
      character(kind=c_char), intent(in) :: name(*)
      type(c_ptr) :: column
      integer(c_int) :: c_table_column
    end function c_table_column
    function c_table_positions(table, positions) bind(c, name='recon_table_positions')
      import :: recon_array, c_ptr, c_int
      type(c_ptr), value :: table
      type(recon_array) :: positions
      integer(c_int) :: c_table_positions
    end function c_table_positions

    function c_simulation_new(path, settings, count, simulation) bind(c, name='recon_simulation_new')
      import :: c_ptr, c_int, c_char, c_size_t
      character(kind=c_char), intent(in) :: path(*)
      type(c_ptr), intent(in) :: settings(*)
      integer(c_size_t), value :: count
      type(c_ptr) :: simulation
      integer(c_int) :: c_simulation_new
    end function c_simulation_new
    subroutine c_simulation_free(simulation) bind(c, name='recon_simulation_free')
      import :: c_ptr
      type(c_ptr), value :: simulation
    end subroutine c_simulation_free
    function c_simulation_dimension(simulation) bind(c, name='recon_simulation_dimension')
      import :: c_ptr, c_int
      type(c_ptr), value :: simulation
      integer(c_int) :: c_simulation_dimension
    end function c_simulation_dimension
    function c_simulation_particles(simulation) bind(c, name='recon_simulation_particles')
      import :: c_ptr, c_size_t
      type(c_ptr), value :: simulation
      integer(c_size_t) :: c_simulation_particles
    end function c_simulation_particles
    function c_simulation_time(simulation) bind(c, name='recon_simulation_time')
      import :: c_ptr, c_double
      type(c_ptr), value :: simulation
      real(c_double) :: c_simulation_time
    end function c_simulation_time
    function c_simulation_end(simulation) bind(c, name='recon_simulation_end')
      import :: c_ptr, c_double
      type(c_ptr), value :: simulation
      real(c_double) :: c_simulation_end
    end function c_simulation_end
    function c_simulation_choose_step(simulation, dt) bind(c, name='recon_simulation_choose_step')
      import :: c_ptr, c_int, c_double
      type(c_ptr), value :: simulation
      real(c_double), intent(out) :: dt
      integer(c_int) :: c_simulation_choose_step
    end function c_simulation_choose_step
    function c_simulation_step(simulation, dt) bind(c, name='recon_simulation_step')
      import :: c_ptr, c_int, c_double
      type(c_ptr), value :: simulation
      real(c_double), value :: dt
      integer(c_int) :: c_simulation_step
    end function c_simulation_step
    function c_simulation_run_until(simulation, time) bind(c, name='recon_simulation_run_until')
      import :: c_ptr, c_int, c_double
      type(c_ptr), value :: simulation
      real(c_double), value :: time
      integer(c_int) :: c_simulation_run_until
    end function c_simulation_run_until
    function c_simulation_array(simulation, name, array) bind(c, name='recon_simulation_array')
      import :: recon_array, c_ptr, c_int, c_char
      type(c_ptr), value :: simulation
      character(kind=c_char), intent(in) :: name(*)
      type(recon_array) :: array
      integer(c_int) :: c_simulation_array
    end function c_simulation_array
  end interface

contains

  ! ---- texts -------------------------------------------------------------------------------------

  function text_of(pointer) result(text)
    type(c_ptr), intent(in) :: pointer
    character(len=:), allocatable :: text
    character(kind=c_char), pointer :: letters(:)
    integer :: i
    call c_f_pointer(pointer, letters, [c_strlen(pointer)])
    allocate (character(len=size(letters)) :: text)
    do i = 1, size(letters)
      text(i:i) = letters(i)
    end do
  end function text_of

  pure function c_text(text) result(out)
    character(len=*), intent(in) :: text
    character(kind=c_char) :: out(len_trim(text) + 1)
    integer :: i
    do i = 1, len_trim(text)
      out(i) = text(i:i)
    end do
    out(len_trim(text) + 1) = c_null_char
  end function c_text

  function recon_version() result(text)
    character(len=:), allocatable :: text
    text = text_of(c_version())
  end function recon_version

  function recon_message() result(text)
    character(len=:), allocatable :: text
    text = text_of(c_message())
  end function recon_message

  ! ---- arrays ------------------------------------------------------------------------------------

  function distance(from, to) result(bytes)
    type(c_ptr), intent(in) :: from, to
    integer(c_intptr_t) :: bytes
    bytes = transfer(to, 0_c_intptr_t) - transfer(from, 0_c_intptr_t)
  end function distance

  function made(n, components, number) result(array)
    integer, intent(in) :: n, components
    integer(c_int), intent(in) :: number
    type(recon_array) :: array
    array%size = n
    array%components = components
    array%number = number
    array%data = c_null_ptr
    array%stride = 0
    array%component_stride = 0
    array%arrays = c_null_ptr
  end function made

  function doubles_1(a) result(array)
    real(c_double), intent(in), target :: a(:)
    type(recon_array) :: array
    array = made(size(a), 1, RECON_DOUBLE)
    if (size(a) > 0) array%data = c_loc(a(1))
    if (size(a) > 1) array%stride = distance(c_loc(a(1)), c_loc(a(2)))
  end function doubles_1

  function doubles_2(a) result(array)
    real(c_double), intent(in), target :: a(:, :)
    type(recon_array) :: array
    array = made(size(a, 2), size(a, 1), RECON_DOUBLE)
    if (size(a) > 0) array%data = c_loc(a(1, 1))
    if (size(a) > 0 .and. size(a, 2) > 1) array%stride = distance(c_loc(a(1, 1)), c_loc(a(1, 2)))
    if (size(a) > 0 .and. size(a, 1) > 1) array%component_stride = distance(c_loc(a(1, 1)), c_loc(a(2, 1)))
  end function doubles_2

  function double_axes_2(x, y) result(array)
    real(c_double), intent(in), target :: x(:), y(:)
    type(recon_array) :: array
    array = joined([doubles_1(x), doubles_1(y)])
  end function double_axes_2

  function double_axes_3(x, y, z) result(array)
    real(c_double), intent(in), target :: x(:), y(:), z(:)
    type(recon_array) :: array
    array = joined([doubles_1(x), doubles_1(y), doubles_1(z)])
  end function double_axes_3

  function floats_1(a) result(array)
    real(c_float), intent(in), target :: a(:)
    type(recon_array) :: array
    array = made(size(a), 1, RECON_FLOAT)
    if (size(a) > 0) array%data = c_loc(a(1))
    if (size(a) > 1) array%stride = distance(c_loc(a(1)), c_loc(a(2)))
  end function floats_1

  function floats_2(a) result(array)
    real(c_float), intent(in), target :: a(:, :)
    type(recon_array) :: array
    array = made(size(a, 2), size(a, 1), RECON_FLOAT)
    if (size(a) > 0) array%data = c_loc(a(1, 1))
    if (size(a) > 0 .and. size(a, 2) > 1) array%stride = distance(c_loc(a(1, 1)), c_loc(a(1, 2)))
    if (size(a) > 0 .and. size(a, 1) > 1) array%component_stride = distance(c_loc(a(1, 1)), c_loc(a(2, 1)))
  end function floats_2

  function float_axes_2(x, y) result(array)
    real(c_float), intent(in), target :: x(:), y(:)
    type(recon_array) :: array
    array = joined([floats_1(x), floats_1(y)])
  end function float_axes_2

  function float_axes_3(x, y, z) result(array)
    real(c_float), intent(in), target :: x(:), y(:), z(:)
    type(recon_array) :: array
    array = joined([floats_1(x), floats_1(y), floats_1(z)])
  end function float_axes_3

  ! An array for each component. Where they differ in length or stride no array can stand for them: it has
  ! no components, which the library refuses.
  function joined(parts) result(array)
    type(recon_array), intent(in) :: parts(:)
    type(recon_array) :: array
    integer :: c
    array = made(int(parts(1)%size), size(parts), parts(1)%number)
    array%stride = parts(1)%stride
    do c = 1, size(parts)
      array%arrays(c) = parts(c)%data
      if (parts(c)%size /= parts(1)%size .or. parts(c)%stride /= parts(1)%stride) array%components = 0
    end do
  end function joined

  ! The numbers of an array of one component without gaps, such as a column of a table.
  subroutine recon_numbers_of(array, numbers)
    type(recon_array), intent(in) :: array
    real(c_double), pointer, intent(out) :: numbers(:, :)
    nullify (numbers)
    if (array%number == RECON_DOUBLE .and. c_associated(array%data)) &
        call c_f_pointer(array%data, numbers, [int(array%components), int(array%size)])
  end subroutine recon_numbers_of

  ! ---- options -----------------------------------------------------------------------------------

  function recon_options_new(options) result(status)
    type(recon_options), intent(out) :: options
    integer(c_int) :: status
    status = c_options_new(options%handle)
  end function recon_options_new

  subroutine recon_options_free(options)
    type(recon_options), intent(inout) :: options
    call c_options_free(options%handle)
    options%handle = c_null_ptr
  end subroutine recon_options_free

  function set_double(options, name, number) result(status)
    type(recon_options), intent(in) :: options
    character(len=*), intent(in) :: name
    real(c_double), intent(in) :: number
    integer(c_int) :: status
    status = c_options_number(options%handle, c_text(name), number)
  end function set_double

  function set_integer(options, name, number) result(status)
    type(recon_options), intent(in) :: options
    character(len=*), intent(in) :: name
    integer, intent(in) :: number
    integer(c_int) :: status
    status = c_options_number(options%handle, c_text(name), real(number, c_double))
  end function set_integer

  function set_text(options, name, text) result(status)
    type(recon_options), intent(in) :: options
    character(len=*), intent(in) :: name, text
    integer(c_int) :: status
    status = c_options_text(options%handle, c_text(name), c_text(text))
  end function set_text

  function set_numbers(options, name, numbers) result(status)
    type(recon_options), intent(in) :: options
    character(len=*), intent(in) :: name
    real(c_double), intent(in) :: numbers(:)
    integer(c_int) :: status
    status = c_options_numbers(options%handle, c_text(name), numbers, int(size(numbers), c_size_t))
  end function set_numbers

  ! Axes are counted from 1, as Fortran's dimensions are.
  function recon_options_periodic(options, axis, lower, upper) result(status)
    type(recon_options), intent(in) :: options
    integer, intent(in) :: axis
    real(c_double), intent(in) :: lower, upper
    integer(c_int) :: status
    status = c_options_periodic(options%handle, int(axis - 1, c_int), lower, upper)
  end function recon_options_periodic

  function recon_options_neighbours(options, offsets, indices, support) result(status)
    type(recon_options), intent(in) :: options
    integer(c_int64_t), intent(in) :: offsets(:)
    integer(c_int32_t), intent(in) :: indices(:)
    real(c_double), intent(in) :: support(:)
    integer(c_int) :: status
    status = c_options_neighbours(options%handle, int(size(support), c_size_t), offsets, indices, support)
  end function recon_options_neighbours

  function recon_options_ellipsoids(options, tensors) result(status)
    type(recon_options), intent(in) :: options
    type(recon_array), intent(in) :: tensors
    integer(c_int) :: status
    status = c_options_ellipsoids(options%handle, tensors)
  end function recon_options_ellipsoids

  ! ---- particles that are kept -------------------------------------------------------------------

  function recon_sources_new(points, options, sources) result(status)
    type(recon_array), intent(in) :: points
    type(recon_options), intent(in) :: options
    type(recon_sources), intent(out) :: sources
    integer(c_int) :: status
    status = c_sources_new(points, options%handle, sources%handle)
  end function recon_sources_new

  function recon_sources_update(sources, points, weights) result(status)
    type(recon_sources), intent(in) :: sources
    type(recon_array), intent(in) :: points
    real(c_double), intent(in), optional, target :: weights(:)
    real(c_double), allocatable, target :: packed(:)
    integer(c_int) :: status
    if (present(weights)) then
      packed = weights
      status = c_sources_update(sources%handle, points, c_loc(packed))
    else
      status = c_sources_update(sources%handle, points, c_null_ptr)
    end if
  end function recon_sources_update

  function recon_sources_size(sources) result(n)
    type(recon_sources), intent(in) :: sources
    integer(c_size_t) :: n
    n = c_sources_size(sources%handle)
  end function recon_sources_size

  subroutine recon_sources_free(sources)
    type(recon_sources), intent(inout) :: sources
    call c_sources_free(sources%handle)
    sources%handle = c_null_ptr
  end subroutine recon_sources_free

  function recon_kernel_sum(sources, targets, amounts, options, out) result(status)
    type(recon_sources), intent(in) :: sources
    type(recon_array), intent(in) :: targets, amounts, out
    type(recon_options), intent(in) :: options
    integer(c_int) :: status
    status = c_kernel_sum(sources%handle, targets, amounts, options%handle, out)
  end function recon_kernel_sum

  ! ---- reconstructions ---------------------------------------------------------------------------

  function recon_reconstruct(points, targets, options, fit) result(status)
    type(recon_array), intent(in) :: points, targets
    type(recon_options), intent(in) :: options
    type(recon_fit), intent(out) :: fit
    integer(c_int) :: status
    status = c_reconstruct(points, targets, options%handle, fit%handle)
  end function recon_reconstruct

  function recon_reconstruct_at_nodes(points, grid, options, fit) result(status)
    type(recon_array), intent(in) :: points
    type(recon_grid), intent(in) :: grid
    type(recon_options), intent(in) :: options
    type(recon_fit), intent(out) :: fit
    integer(c_int) :: status
    status = c_reconstruct_at_nodes(points, grid, options%handle, fit%handle)
  end function recon_reconstruct_at_nodes

  function recon_reconstruct_from(sources, targets, options, fit) result(status)
    type(recon_sources), intent(in) :: sources
    type(recon_array), intent(in) :: targets
    type(recon_options), intent(in) :: options
    type(recon_fit), intent(out) :: fit
    integer(c_int) :: status
    status = c_reconstruct_from(sources%handle, targets, options%handle, fit%handle)
  end function recon_reconstruct_from

  function recon_fit_update(fit, targets) result(status)
    type(recon_fit), intent(in) :: fit
    type(recon_array), intent(in) :: targets
    integer(c_int) :: status
    status = c_fit_update(fit%handle, targets)
  end function recon_fit_update

  subroutine recon_fit_free(fit)
    type(recon_fit), intent(inout) :: fit
    call c_fit_free(fit%handle)
    fit%handle = c_null_ptr
  end subroutine recon_fit_free

  function recon_fit_targets(fit) result(n)
    type(recon_fit), intent(in) :: fit
    integer(c_size_t) :: n
    n = c_fit_targets(fit%handle)
  end function recon_fit_targets

  function recon_fit_particles(fit) result(n)
    type(recon_fit), intent(in) :: fit
    integer(c_size_t) :: n
    n = c_fit_particles(fit%handle)
  end function recon_fit_particles

  function recon_fit_apply(fit, field, out) result(status)
    type(recon_fit), intent(in) :: fit
    type(recon_array), intent(in) :: field, out
    integer(c_int) :: status
    status = c_fit_apply(fit%handle, field, out)
  end function recon_fit_apply

  function recon_fit_apply_limited(fit, field, limit, out) result(status)
    type(recon_fit), intent(in) :: fit
    type(recon_array), intent(in) :: field, out
    character(len=*), intent(in) :: limit
    integer(c_int) :: status
    status = c_fit_apply_limited(fit%handle, field, c_text(limit), out)
  end function recon_fit_apply_limited

  function recon_fit_apply_transpose(fit, field, out) result(status)
    type(recon_fit), intent(in) :: fit
    type(recon_array), intent(in) :: field, out
    integer(c_int) :: status
    status = c_fit_apply_transpose(fit%handle, field, out)
  end function recon_fit_apply_transpose

  function recon_fit_report(fit, name, out) result(status)
    type(recon_fit), intent(in) :: fit
    character(len=*), intent(in) :: name
    real(c_double), intent(inout) :: out(:)
    integer(c_int) :: status
    status = c_fit_report(fit%handle, c_text(name), out, int(size(out), c_size_t))
  end function recon_fit_report

  function recon_fit_operator(fit, name, op) result(status)
    type(recon_fit), intent(in) :: fit
    character(len=*), intent(in) :: name
    type(recon_operator), intent(out) :: op
    integer(c_int) :: status
    status = c_fit_operator(fit%handle, c_text(name), op%handle)
  end function recon_fit_operator

  subroutine recon_operator_free(op)
    type(recon_operator), intent(inout) :: op
    call c_operator_free(op%handle)
    op%handle = c_null_ptr
  end subroutine recon_operator_free

  function recon_operator_components(op, of_field) result(n)
    type(recon_operator), intent(in) :: op
    integer, intent(in) :: of_field
    integer(c_int) :: n
    n = c_operator_components(op%handle, int(of_field, c_int))
  end function recon_operator_components

  function recon_operator_apply(op, field, out) result(status)
    type(recon_operator), intent(in) :: op
    type(recon_array), intent(in) :: field, out
    integer(c_int) :: status
    status = c_operator_apply(op%handle, field, out)
  end function recon_operator_apply

  function recon_operator_apply_transpose(op, field, out) result(status)
    type(recon_operator), intent(in) :: op
    type(recon_array), intent(in) :: field, out
    integer(c_int) :: status
    status = c_operator_apply_transpose(op%handle, field, out)
  end function recon_operator_apply_transpose

  function recon_operator_add(op, factor, other) result(status)
    type(recon_operator), intent(in) :: op, other
    real(c_double), intent(in) :: factor
    integer(c_int) :: status
    status = c_operator_add(op%handle, factor, other%handle)
  end function recon_operator_add

  ! gradients, 'diffuse' or 'exact', and gradients_out are given together or not at all.
  function recon_on_grid(points, field, grid, options, out, gradients, gradients_out) result(status)
    type(recon_array), intent(in) :: points, field, out
    type(recon_grid), intent(in) :: grid
    type(recon_options), intent(in) :: options
    character(len=*), intent(in), optional :: gradients
    type(recon_array), intent(in), optional :: gradients_out
    character(kind=c_char), allocatable, target :: kind(:)
    integer(c_int) :: status
    if (present(gradients) .and. present(gradients_out)) then
      kind = c_text(gradients)
      status = c_on_grid(points, field, grid, options%handle, out, c_loc(kind), gradients_out)
    else
      status = c_on_grid(points, field, grid, options%handle, out, c_null_ptr, out)
    end if
  end function recon_on_grid

  ! ---- files -------------------------------------------------------------------------------------

  function recon_read(path, frame, table) result(status)
    character(len=*), intent(in) :: path
    integer, intent(in) :: frame
    type(recon_table), intent(out) :: table
    integer(c_int) :: status
    status = c_read(c_text(path), int(frame, c_int), table%handle)
  end function recon_read

  subroutine recon_table_free(table)
    type(recon_table), intent(inout) :: table
    call c_table_free(table%handle)
    table%handle = c_null_ptr
  end subroutine recon_table_free

  function recon_table_size(table) result(n)
    type(recon_table), intent(in) :: table
    integer(c_size_t) :: n
    n = c_table_size(table%handle)
  end function recon_table_size

  ! A column, which lives as long as the table.
  function recon_table_column(table, name, column) result(status)
    type(recon_table), intent(in) :: table
    character(len=*), intent(in) :: name
    real(c_double), pointer, intent(out) :: column(:)
    integer(c_int) :: status
    type(c_ptr) :: address
    nullify (column)
    status = c_table_column(table%handle, c_text(name), address)
    if (status == RECON_OK) call c_f_pointer(address, column, [recon_table_size(table)])
  end function recon_table_column

  function recon_table_positions(table, positions) result(status)
    type(recon_table), intent(in) :: table
    type(recon_array), intent(out) :: positions
    integer(c_int) :: status
    status = c_table_positions(table%handle, positions)
  end function recon_table_positions

  ! ---- the material point method -----------------------------------------------------------------

  function recon_simulation_new(path, settings, simulation) result(status)
    character(len=*), intent(in) :: path
    character(len=*), intent(in) :: settings(:)
    type(recon_simulation), intent(out) :: simulation
    integer(c_int) :: status
    character(kind=c_char), allocatable, target :: letters(:, :)
    type(c_ptr) :: addresses(size(settings))
    integer :: i
    allocate (letters(len(settings) + 1, size(settings)))
    do i = 1, size(settings)
      letters(1:len_trim(settings(i)) + 1, i) = c_text(settings(i))
      addresses(i) = c_loc(letters(1, i))
    end do
    status = c_simulation_new(c_text(path), addresses, int(size(settings), c_size_t), simulation%handle)
  end function recon_simulation_new

  subroutine recon_simulation_free(simulation)
    type(recon_simulation), intent(inout) :: simulation
    call c_simulation_free(simulation%handle)
    simulation%handle = c_null_ptr
  end subroutine recon_simulation_free

  function recon_simulation_dimension(simulation) result(n)
    type(recon_simulation), intent(in) :: simulation
    integer(c_int) :: n
    n = c_simulation_dimension(simulation%handle)
  end function recon_simulation_dimension

  function recon_simulation_particles(simulation) result(n)
    type(recon_simulation), intent(in) :: simulation
    integer(c_size_t) :: n
    n = c_simulation_particles(simulation%handle)
  end function recon_simulation_particles

  function recon_simulation_time(simulation) result(time)
    type(recon_simulation), intent(in) :: simulation
    real(c_double) :: time
    time = c_simulation_time(simulation%handle)
  end function recon_simulation_time

  function recon_simulation_end(simulation) result(time)
    type(recon_simulation), intent(in) :: simulation
    real(c_double) :: time
    time = c_simulation_end(simulation%handle)
  end function recon_simulation_end

  function recon_simulation_choose_step(simulation, dt) result(status)
    type(recon_simulation), intent(in) :: simulation
    real(c_double), intent(out) :: dt
    integer(c_int) :: status
    status = c_simulation_choose_step(simulation%handle, dt)
  end function recon_simulation_choose_step

  function recon_simulation_step(simulation, dt) result(status)
    type(recon_simulation), intent(in) :: simulation
    real(c_double), intent(in) :: dt
    integer(c_int) :: status
    status = c_simulation_step(simulation%handle, dt)
  end function recon_simulation_step

  function recon_simulation_run_until(simulation, time) result(status)
    type(recon_simulation), intent(in) :: simulation
    real(c_double), intent(in) :: time
    integer(c_int) :: status
    status = c_simulation_run_until(simulation%handle, time)
  end function recon_simulation_run_until

  function recon_simulation_array(simulation, name, array) result(status)
    type(recon_simulation), intent(in) :: simulation
    character(len=*), intent(in) :: name
    type(recon_array), intent(out) :: array
    integer(c_int) :: status
    status = c_simulation_array(simulation%handle, c_text(name), array)
  end function recon_simulation_array

end module recon
