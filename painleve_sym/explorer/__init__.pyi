from painleve_sym.explorer.page import Page as Page
from painleve_sym.explorer.page import explore as explore
