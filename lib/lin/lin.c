/* Set-up of the process for the numerical libraries. */
#include "lin.h"

#include <gsl/gsl_errno.h>

void lin_init(void)
{
    gsl_set_error_handler_off();
}
